"""What is public is described and typed."""
import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import rangegrasp as rg
from rangegrasp import _core
import rangegrasp.gym  # noqa: F401

PACKAGE = Path(rg.__file__).parent


def test_the_version_is_the_program_s():
    told = subprocess.run([sys.executable, "-m", "rangegrasp", "--version"], capture_output=True, text=True, check=True).stdout
    assert told.strip() == f"rangegrasp {rg.__version__}" and re.fullmatch(r"\d+\.\d+\.\d+", rg.__version__)


def test_everything_public_has_a_docstring():
    for name in rg.__all__:
        thing = getattr(rg, name)
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing):
            for part, value in vars(thing).items():
                if not part.startswith("_") and callable(value):
                    assert inspect.getdoc(value), f"{name}.{part}"


def test_the_stub_names_what_the_module_has():
    tree = ast.parse((PACKAGE / "_core.pyi").read_text())
    stub = {node.name for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert stub == {name for name in dir(_core) if not name.startswith("_")}
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name == "Scene":
            parts = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
            assert parts - {"__init__"} == {name for name in dir(_core.Scene) if not name.startswith("_")}


def test_messages_go_to_python_s_log(caplog):
    import logging
    with caplog.at_level(logging.INFO, logger="rangegrasp"):
        rg.evaluate(None, "single", trials=1, objects=["coffee_cup"], seed=4711, progress=False)
    assert any("1 case in" in record.message for record in caplog.records)

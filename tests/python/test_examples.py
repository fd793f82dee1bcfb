"""The examples run, and the notebooks from start to end."""
import contextlib
import importlib.util
import io
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rangegrasp as rg

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def module_of(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / "python" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["straight_down", "from_above", "antipodal"])
def test_a_detector_delivers(name):
    objects = ["salt_cylinder", "dextrose", "coffee_cup", "cleaner"]
    results = rg.evaluate(module_of(name).detect, "single", trials=1, objects=objects, seed=4711, progress=False)
    outcomes = [row["outcome"] for row in results.rows]
    assert outcomes.count("delivered") >= 3, outcomes
    assert not {"detector_failed", "crashed", "timed_out"} & set(outcomes)


def test_the_policies_clear_tables():
    printed = subprocess.run([sys.executable, EXAMPLES / "python/policies.py", "2", "2"], capture_output=True, text=True, check=True).stdout
    lines = re.findall(r"^(.+): (\d) objects delivered in 2 attempts of 1 episodes$", printed, re.MULTILINE)
    assert [name for name, _ in lines] == ["random", "best proposal not yet tried", "learnt"], printed
    assert sum(int(delivered) for _, delivered in lines) >= 2, printed


def test_a_data_set_is_read(tmp_path):
    rg.collect(tmp_path / "d", "single", scenes=2, grasps=2, seed=4711, jobs=1)
    points, X_WG, width, delivered = next(iter(module_of("read_data_set").grasps_of(tmp_path / "d")))
    assert points.shape == (150, 512, 3) and X_WG.shape == (4, 4) and width > 0 and delivered in (True, False)


def test_a_damaged_data_set_is_named(tmp_path):
    script = EXAMPLES / "python/read_data_set.py"
    shard = tmp_path / "shard-00000.npz"
    ran = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True)
    assert ran.returncode == 1 and ran.stderr == f"{script}: {tmp_path}: no shard-*.npz; rangegrasp.collect writes data sets\n"
    shapes = {"points": (1, 2, 2, 3), "X_WG": (4, 4, 4), "width": 4, "outcome": 4}
    arrays = {name: np.zeros(shape) for name, shape in shapes.items()}
    np.savez(shard, **arrays, scene=np.zeros(4, int))
    whole = shard.read_bytes()
    assert len(list(module_of("read_data_set").grasps_of(tmp_path))) == 4
    np.savez(shard, **arrays, scene=np.ones(4, int))
    for damaged in (shard.read_bytes(), b"", b"PK", whole[:len(whole) // 2]):
        shard.write_bytes(damaged)
        ran = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True)
        assert ran.returncode == 1 and ran.stderr.startswith(f"{script}: {shard}: is not a whole shard of a data set: "), ran.stderr


def shortened(code, changes):
    for long, short in changes.items():
        assert long in code
        code = code.replace(long, short)
    return code


SHORT = {"3_compare_two": {"trials=3": "trials=1, objects=['spread', 'dextrose']"}, "4_train_a_score": {"scenes=24": "scenes=4", "trials=1": "trials=1, objects=['spread']"}}


def test_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (EXAMPLES.parent / "docs/python.md").read_text()
    fences = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(fences) == 3
    code = shortened("\n".join(fences), {"trials=10": "trials=1, objects=['spread', 'dextrose']", "scenes=100": "scenes=2", "grasps=8": "grasps=2"})
    names = {}
    exec(compile(code, "docs/python.md", "exec"), names)
    assert names["outcome"].word and (tmp_path / "report/index.html").exists() and (tmp_path / "data/card.json").exists()


@pytest.mark.parametrize("file", sorted((EXAMPLES / "notebooks").glob("*.ipynb")), ids=lambda file: file.stem)
def test_a_notebook_runs(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "notebook"}
    cells = [cell for cell in json.loads(file.read_text())["cells"] if cell["cell_type"] == "code"]
    assert any("image/png" in one.get("data", {}) for cell in cells for one in cell["outputs"]), "stored without its pictures"
    with contextlib.redirect_stdout(io.StringIO()):
        code = shortened("\n".join("".join(cell["source"]) for cell in cells), SHORT.get(file.stem, {}))
        exec(compile(code, file.name, "exec"), names)

"""The package and its examples are typed."""
import os
import subprocess
import sys
from pathlib import Path

import rangegrasp as rg

ROOT = Path(__file__).resolve().parents[2]


def test_mypy_finds_nothing(tmp_path):
    files = [*sorted((ROOT / "python/rangegrasp").glob("*.py")), *sorted((ROOT / "examples/python").glob("*.py"))]
    assert len(files) > 10 and rg.__version__
    told = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir", tmp_path, *files],
                          capture_output=True, text=True, env={**os.environ, "MYPYPATH": str(ROOT / "python")})
    assert told.returncode == 0, told.stdout

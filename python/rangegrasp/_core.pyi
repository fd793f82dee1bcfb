"""C++ core of the testbed; use the package rangegrasp instead."""

from collections.abc import Callable, Sequence
from typing import Any, overload

import numpy
from numpy.typing import NDArray


class RunError(RuntimeError):
    """A run that failed through no fault of its input, e.g. a full disk."""

class InputError(ValueError):
    """
    Bad input; the text names the file, the line or key, the value and what would be right.
    """

def version() -> str:
    """The version, e.g. '0.5.0'."""

def main(words: Sequence[str]) -> int:
    """Runs the command line with its words; the first is the program's name."""

def data_folder() -> str:
    """The folder of models/, scenes/ and experiments/."""

def experiments() -> list[str]:
    """The names of the experiments that come with the package."""

def feature_names() -> list[str]: ...

def objects(experiment: str, set: Sequence[str]) -> list[str]: ...

class SavedScene:
    pass

class Scene:
    @overload
    def __init__(self, experiment: str, set: Sequence[str], seed: int, target: str, index: int) -> None: ...

    @overload
    def __init__(self, experiment: str, set: Sequence[str], seed: int, objects: Sequence[tuple[str, NDArray[numpy.float64]]]) -> None: ...

    def scan(self, seed: int) -> dict[str, Any]: ...

    def perceive(self, seed: int, features: bool) -> dict[str, Any]: ...

    def grasp(self, X_WG: NDArray[numpy.float64], width: float, approach: NDArray[numpy.float64], samples: Sequence[int], seed: int) -> tuple[str, str, str, dict[str, Any]]: ...

    def render(self, camera: str, width: int, height: int) -> NDArray[numpy.uint8]: ...

    def take_away(self) -> list[str]: ...

    def truth(self) -> dict[str, Any]: ...

    def save(self) -> SavedScene: ...

    def restore(self, state: SavedScene) -> None: ...

    @property
    def seed(self) -> int: ...

    @property
    def warnings(self) -> list[str]: ...

def perceive(scan: dict[str, Any], crop: Sequence[float] | None, noise_m: float | None, up: NDArray[numpy.float64] | None, segmentation: str, scene: str, seed: int, grasped: int, pose_is_known: bool) -> dict[str, Any]: ...

def run(experiment: str, set: Sequence[str], trials: int | None, objects: Sequence[str], seeds: Sequence[int], out: str, jobs: int, resume: bool, overwrite: bool, ask: object | None, name: str, progress: Callable[[int, int, str], None]) -> str: ...

def table(folder: str, format: str) -> str: ...

def records(folder: str) -> list[dict[str, Any]]: ...

def compare(first: str, second: str) -> dict[str, Any]: ...

def report(folder: str, jobs: int, ask: object | None, name: str, run_detector: bool) -> None: ...

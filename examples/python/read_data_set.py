"""Reads a data set of `rangegrasp.collect` with NumPy alone, and as a PyTorch data set where PyTorch is installed (docs/python.md)."""
import sys
from pathlib import Path
from typing import Any, Iterator

import numpy as np
from numpy.typing import NDArray


def read_shard(file: Path) -> list[NDArray[Any]]:
    """The arrays points, scene, X_WG, width and outcome."""
    try:
        with np.load(file) as shard:
            points, scene, *others = arrays = [shard[name] for name in ("points", "scene", "X_WG", "width", "outcome")]
        if any(len(array) != len(scene) for array in others):
            raise ValueError("its arrays have different lengths")
        if not ((scene >= 0) & (scene < len(points))).all():
            raise ValueError("a grasp is of a scene that it does not have")
        return arrays
    except Exception as error:  # a damaged file raises errors of many kinds
        raise ValueError(f"{file}: is not a whole shard of a data set: {error}") from error


def grasps_of(folder: str | Path) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float64], float, bool]]:
    """Yields (points (rows, columns, 3), X_WG (4, 4), width, delivered) of each grasp."""
    files = sorted(Path(folder).glob("shard-*.npz"))
    if not files:
        raise ValueError(f"{folder}: no shard-*.npz; rangegrasp.collect writes data sets")
    for file in files:
        points, scenes, poses, widths, outcomes = read_shard(file)
        for scene, X_WG, width, outcome in zip(scenes, poses, widths, outcomes):
            yield points[scene], X_WG, float(width), bool(outcome == "delivered")


def torch_data_set(folder: str | Path) -> Any:
    import torch

    class Grasps:  # a data set for torch.utils.data.DataLoader
        def __init__(self) -> None:
            self.items = [(torch.from_numpy(np.nan_to_num(points)), torch.from_numpy(X), float(width), float(delivered))
                          for points, X, width, delivered in grasps_of(folder)]

        def __len__(self) -> int:
            return len(self.items)

        def __getitem__(self, i: int) -> Any:
            return self.items[i]
    return Grasps()


if __name__ == "__main__":
    try:
        delivered = [one[3] for one in grasps_of(sys.argv[1])]
    except ValueError as error:
        sys.exit(f"{sys.argv[0]}: {error}")
    print(f"{len(delivered)} grasps, {100 * np.mean(delivered):.0f} % delivered")

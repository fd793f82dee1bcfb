"""Reads a data set of `rangegrasp.collect` with NumPy alone, and as a PyTorch data set where PyTorch is installed (docs/python.md)."""
import sys
from pathlib import Path
from typing import Any, Iterator

import numpy as np
from numpy.typing import NDArray


def grasps_of(folder: str | Path) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float64], float, bool]]:
    """Yields (points (rows, columns, 3), X_WG (4, 4), width, delivered) of each grasp."""
    for file in sorted(Path(folder).glob("shard-*.npz")):
        with np.load(file) as shard:
            points = shard["points"]
            for i, scene in enumerate(shard["scene"]):
                yield points[scene], shard["X_WG"][i], float(shard["width"][i]), bool(shard["outcome"][i] == "delivered")


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
    delivered = [one[3] for one in grasps_of(sys.argv[1])]
    print(f"{len(delivered)} grasps, {100 * np.mean(delivered):.0f} % delivered")

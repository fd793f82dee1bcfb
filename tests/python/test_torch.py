"""A PyTorch model as a detector: in forked processes after the model was used in this one, and in batches in this process."""
import numpy as np
import pytest

import rangegrasp as rg

torch = pytest.importorskip("torch")

FEW = dict(trials=1, objects=["coffee_cup", "salt_cuboid", "dextrose"], seed=4711, progress=False)
HEIGHTS = 64


class HighestPoint(torch.nn.Module):
    """Scores points by their height in a small network with fixed weights; straight down on the best."""

    def __init__(self):
        super().__init__()
        generator = torch.Generator().manual_seed(1)
        self.hidden = torch.nn.Linear(1, HEIGHTS)
        self.out = torch.nn.Linear(HEIGHTS, 1)
        with torch.no_grad():
            self.hidden.weight.copy_(torch.rand(HEIGHTS, 1, generator=generator))
            self.hidden.bias.zero_()
            self.out.weight.fill_(1 / HEIGHTS)

    def forward(self, heights):
        return self.out(torch.relu(self.hidden(heights)))


def tensor(heights):  # without NumPy's interface, which is another one in each major version
    return torch.frombuffer(bytearray(np.ascontiguousarray(heights, dtype=np.float32).tobytes()), dtype=torch.float32)[:, None]


def grasps_of(scan, model):
    points = scan.points[scan.mask]
    points = points[np.abs(points[:, :2]).max(axis=1) < 0.15]
    with torch.no_grad():
        best = int(model(tensor(points[:, 2])).argmax())
    X_WG = np.diag([1.0, -1.0, -1.0, 1.0])
    X_WG[:3, 3] = points[best] - [0, 0, 0.02]
    return [rg.Grasp(X_WG, 0.09)]


def essence(results):
    return [{key: row[key] for key in ("id", "outcome", "detail")} for row in results.rows]


def test_a_model_answers_in_forked_processes_and_in_batches():
    model = HighestPoint().eval()
    with torch.no_grad():
        model(torch.rand(1_000_000, 1))  # starts the threads of this process, which no fork has
    assert torch.get_num_threads() >= 1

    def detect(scan):
        return grasps_of(scan, model)
    one = rg.evaluate(detect, "single", jobs=1, **FEW)
    two = rg.evaluate(detect, "single", jobs=2, **FEW)
    batched = rg.evaluate(lambda scans: [detect(scan) for scan in scans], "single", jobs=2, batch=2, **FEW)
    assert essence(one) == essence(two) == essence(batched)
    assert not {"detector_failed", "crashed", "timed_out"} & {row["outcome"] for row in one.rows}, one.table()

"""The baseline as a function: straight down onto the highest thing, across its shorter side (docs/python.md)."""
import numpy as np
import rangegrasp as rg

CELL_M = 0.008  # points in neighboring cells of this size, seen from above, are connected


def detect(scan: rg.Scan) -> list[rg.Grasp]:
    flat = scan.points.reshape(-1, 3)
    near = np.linalg.norm(flat[:, :2] - scan.center[:2], axis=1) < scan.radius  # false for NaN
    points = flat[near & (flat[:, 2] > max(0.006, 6 * scan.noise_m))]
    if len(points) < 50:
        return []
    cells = [(int(x), int(y)) for x, y in np.floor(points[:, :2] / CELL_M)]
    highest = int(np.argmax(points[:, 2]))
    left, front, own_cells = set(cells), [cells[highest]], set[tuple[int, int]]()
    while front:
        x, y = front.pop()
        own_cells.add((x, y))
        new = {(x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
        left -= new
        front.extend(new)
    own = points[[cell in own_cells for cell in cells]]
    middle, top = 0.5 * (own.min(axis=0) + own.max(axis=0)), points[highest, 2]
    short = np.linalg.eigh(np.cov(own[:, :2].T))[1][:, 0]  # the direction of the least spread
    z, grasps = np.array([0.0, 0.0, -1.0]), list[rg.Grasp]()
    for x_axis in (np.array([*short, 0.0]), np.array([*-short, 0.0])):  # the thumb on either side
        X_WG = np.eye(4)
        X_WG[:3, :3] = np.stack([x_axis, np.cross(z, x_axis), z], axis=1)
        X_WG[:3, 3] = [*middle[:2], max(top - 0.03, min(0.01, top / 2))]
        grasps.append(rg.Grasp(X_WG, float(np.ptp(own @ x_axis))))
    return grasps


if __name__ == "__main__":
    print(rg.evaluate(detect, "single", trials=2))

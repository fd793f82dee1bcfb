"""The baseline as a function: straight down on what is highest, across its shorter side (docs/python.md)."""
import numpy as np
import rangegrasp as rg


def detect(scan):
    flat = scan.points.reshape(-1, 3)
    near = np.linalg.norm(flat[:, :2] - scan.center[:2], axis=1) < scan.radius  # NaN: not
    points = flat[near & (flat[:, 2] > max(0.006, 6 * scan.noise_m))]
    if len(points) < 50:
        return []
    top = points[np.argmax(points[:, 2])]
    own = points[np.linalg.norm(points[:, :2] - top[:2], axis=1) < 0.05]
    middle = 0.5 * (own.min(axis=0) + own.max(axis=0))
    short = np.linalg.eigh(np.cov(own[:, :2].T))[1][:, 0]  # the direction of the least spread
    x, z = np.array([*short, 0.0]), np.array([0.0, 0.0, -1.0])
    X_WG = np.eye(4)
    X_WG[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    X_WG[:3, 3] = [*middle[:2], max(top[2] - 0.03, min(0.01, top[2] / 2))]
    return [rg.Grasp(X_WG, float(np.ptp(own @ x)))]


if __name__ == "__main__":
    print(rg.evaluate(detect, "single", trials=2))

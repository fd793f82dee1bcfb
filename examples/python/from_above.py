"""Finds only grasps, no objects: pairs of opposite edges of the highest thing (docs/python.md)."""
import numpy as np
import rangegrasp as rg


def detect(scan: rg.Scan) -> list[rg.Grasp]:
    flat = scan.points.reshape(-1, 3)
    near = np.linalg.norm(flat[:, :2] - scan.center[:2], axis=1) < scan.radius
    points = flat[near & (flat[:, 2] > max(0.006, 6 * scan.noise_m))]
    if len(points) < 50:
        return []
    top = points[np.argmax(points[:, 2])]
    upper = points[(points[:, 2] > top[2] - 0.04) & (np.linalg.norm(points[:, :2] - top[:2], axis=1) < 0.08)]
    middle, grasps = upper.mean(axis=0), list[rg.Grasp]()
    for angle in np.arange(16) * 2 * np.pi / 16:
        x, z = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, -1.0])
        y = np.cross(z, x)
        between = upper[np.abs((upper - middle) @ y) < 0.015]
        low, high = np.quantile(between @ x, [0.01, 0.99])
        if len(between) < 10 or high - low > scan.max_opening - 0.005:
            continue
        X_WG = np.eye(4)
        X_WG[:3, :3] = np.stack([x, y, z], axis=1)
        X_WG[:3, 3] = [*(middle + (0.5 * (low + high) - middle @ x) * x)[:2], max(top[2] - 0.03, 0.01)]
        grasps.append(rg.Grasp(X_WG, float(high - low), score=-float(high - low)))
    return grasps


if __name__ == "__main__":
    print(rg.evaluate(detect, "single", trials=2))

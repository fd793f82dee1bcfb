"""Uses objects of the built-in perception; finds grasps from the normals on opposite sides (docs/python.md)."""
import numpy as np
import rangegrasp as rg
from numpy.typing import NDArray


def normals_of(scan: rg.Scan) -> NDArray[np.float64]:
    """Normals of all samples towards the sensor, from their neighbors in the image; (rows * columns, 3)."""
    image, normals = scan.points, np.full_like(scan.points, np.nan)
    cross = np.cross(image[2:-2, 4:] - image[2:-2, :-4], image[4:, 2:-2] - image[:-4, 2:-2])
    normals[2:-2, 2:-2] = cross / np.maximum(np.linalg.norm(cross, axis=-1, keepdims=True), 1e-12)
    away = np.sum(normals * (image - scan.X_WV[:3, 3]), axis=-1) > 0
    normals[away] *= -1
    return normals.reshape(-1, 3)


def detect(scan: rg.Scan) -> rg.Detection:
    found, normals, grasps = rg.perceive(scan, grasped=0), normals_of(scan), list[rg.Grasp]()
    if not found.objects:
        return rg.Detection([])
    up, thing = found.table_normal, found.objects[0]
    points, facing = scan.points.reshape(-1, 3)[thing.samples], normals[thing.samples]
    heights = points @ up + found.table_offset
    across = np.cross(up, [0.0, 1.0, 0.0])
    for angle in np.arange(36) * 2 * np.pi / 36:
        x = np.cos(angle) * across + np.sin(angle) * np.cross(up, across)
        y = np.cross(-up, x)
        strip = np.abs((points - points.mean(axis=0)) @ y) < 0.018
        along = points[strip] @ x
        low, high = np.quantile(along, [0.01, 0.99]) if strip.sum() > 10 else (0.0, 1.0)
        if high - low > scan.max_opening - 0.004:
            continue
        ends = np.concatenate([-(facing[strip] @ x)[along < low + 0.006], (facing[strip] @ x)[along > high - 0.006]])
        X_WG, center = np.eye(4), points[strip].mean(axis=0)
        center += (0.5 * (low + high) - center @ x) * x
        center += (max(heights[strip].max() - 0.03, 0.01) - (center @ up + found.table_offset)) * up
        X_WG[:3, :3], X_WG[:3, 3] = np.stack([x, y, -up], axis=1), center
        grasps.append(rg.Grasp(X_WG, float(high - low), score=float(np.nanmean(np.clip(ends, 0, 1)) - 3 * (high - low))))
    return rg.Detection(grasps, [one.samples for one in found.objects])


if __name__ == "__main__":
    print(rg.evaluate(detect, "single", trials=2))

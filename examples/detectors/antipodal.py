#!/usr/bin/env python3
"""An example of a grasp detector in Python with numpy alone (docs/bring-your-own-detector.md).

The table is a plane found by RANSAC. Objects are connected regions of the range image above it.
Grasps come from above, with two contacts on opposite sides of the object. The normal of a visible
contact must point along the closing direction; a hidden contact is assumed to be where the object's
points end.
"""
import json
import sys

import numpy as np

CLEARANCE_M = 0.006  # above the table: a few times the scanner's noise
LINK_M = 0.012  # neighbors in the image that are further apart belong to two objects
MIN_POINTS = 40
FINGERS_M = 0.018  # half of the hand's breadth: points in this strip are between the fingers
DEPTHS_M = (0.030, 0.020, 0.012)  # depths of the pads' middle below the top of the gripped part
ABOVE_TABLE_M = 0.010  # minimum height of the pads' middle; collisions of the fingertips are checked later
DIRECTIONS = 48  # a box looks 2 mm wider to a strip that is rotated by 4 degrees
ROOM_M = 0.004  # between the open pads and the widest object
SHIFTS_M = (0.0, -0.015, 0.015)  # shifts of the hand along the object, from its middle


def read_pcd(name):
    """The cloud as rows x columns x 3, NaN where nothing was measured."""
    with open(name, "rb") as file:
        header = {}
        while header.get("DATA") is None:
            key, *values = file.readline().decode().split() or [""]
            header[key] = values
        fields = np.dtype({"names": header["FIELDS"],
                           "formats": [f"<{t.lower()}{s}" for t, s in zip(header["TYPE"], header["SIZE"])]})
        data = np.frombuffer(file.read(), fields)
    points = np.stack([data[axis] for axis in "xyz"], axis=-1).astype(float)
    return points.reshape(int(header["HEIGHT"][0]), int(header["WIDTH"][0]), 3)


def find_table(points, up, noise_m, rng):
    """Normal and offset of the plane (RANSAC) with the most nearby points, perpendicular to `up` within 10 degrees."""
    sample = points[rng.choice(len(points), min(len(points), 5000), replace=False)]
    best, best_count = None, 0
    for _ in range(200):
        a, b, c = sample[rng.choice(len(sample), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-9 or abs(normal @ up) < 0.985 * length:
            continue
        normal *= np.sign(normal @ up) / length
        near = np.abs((sample - a) @ normal) < max(0.002, 3 * noise_m)
        if near.sum() > best_count:
            best, best_count = near, near.sum()
    if best is None:
        raise SystemExit("no table")
    middle = sample[best].mean(axis=0)
    normal = np.linalg.svd(sample[best] - middle, full_matrices=False)[2][2]
    normal *= np.sign(normal @ up)
    return normal, -normal @ middle


def estimate_normals(image, origin):
    """Normals towards the sensor: cross products of differences to neighbors two samples away in the image."""
    normals = np.full_like(image, np.nan)
    across = image[2:-2, 4:] - image[2:-2, :-4]
    along = image[4:, 2:-2] - image[:-4, 2:-2]
    cross = np.cross(across, along)
    length = np.linalg.norm(cross, axis=-1, keepdims=True)
    normals[2:-2, 2:-2] = cross / np.where(length > 0, length, np.nan)
    away = np.sum(normals * (image - origin), axis=-1) > 0
    normals[away] *= -1
    return normals


def connected(image, mask):
    """Objects: lists of connected positions in the image (row-major), largest first."""
    rows, columns = mask.shape
    flat, waiting = image.reshape(-1, 3), set(np.flatnonzero(mask))
    objects = []
    while waiting:
        front, found = [waiting.pop()], []
        while front:
            at = front.pop()
            found.append(at)
            row, column = divmod(at, columns)
            for r in range(max(0, row - 1), min(rows, row + 2)):
                for c in range(max(0, column - 2), min(columns, column + 3)):
                    near = r * columns + c
                    if near in waiting and np.sum((flat[near] - flat[at]) ** 2) < LINK_M**2:
                        waiting.remove(near)
                        front.append(near)
        if len(found) >= MIN_POINTS:
            objects.append(sorted(found))
    return sorted(objects, key=len, reverse=True)


def grasps_from_above(points, normals, up, height, opening_m):
    """Candidates over all closing directions: the hand comes down and closes along x."""
    x_axis = np.cross(up, [0.0, 1.0, 0.0])
    x_axis /= np.linalg.norm(x_axis)
    y_axis = np.cross(up, x_axis)
    tops = points[height(points) > height(points).max() - 0.012]
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    middle = 0.5 * middle + 0.5 * tops.mean(axis=0)
    for angle in np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS:
        x = np.cos(angle) * x_axis + np.sin(angle) * y_axis
        z = -up
        y = np.cross(z, x)
        for shift in SHIFTS_M:
            origin = middle + shift * y
            strip = np.abs((points - origin) @ y) < FINGERS_M
            if strip.sum() < 10:
                continue
            local, facing = points[strip], normals[strip] @ x
            along = (local - origin) @ x
            low, high = np.quantile(along, [0.01, 0.99])
            width = high - low
            if width > opening_m - ROOM_M:
                continue
            # Antipodal: at a visible end, normals point outwards along x.
            ends = np.concatenate([-facing[along < low + 0.006], facing[along > high - 0.006]])
            agreement = np.nanmean(np.clip(ends, 0, 1)) if np.isfinite(ends).any() else 0.3
            top = height(local).max()
            for depth in DEPTHS_M:
                at = max(top - depth, min(ABOVE_TABLE_M, 0.5 * top))
                center = origin + 0.5 * (low + high) * x
                center += (at - height(center[None])[0]) * up
                score = agreement - 4 * abs(shift) - 3 * width + 5 * min(depth, top - at)
                yield {"position_m": center.tolist(), "rotation": np.stack([x, y, z], axis=1).tolist(),
                       "width_m": float(width), "approach": z.tolist(), "score": float(score)}


def detect(question):
    rng = np.random.default_rng(question["seed"])
    image = read_pcd(question["observation"])
    workspace = question["workspace"]
    up = np.array(workspace["up"])
    flat = image.reshape(-1, 3)
    off = flat - workspace["center_m"]
    off -= np.outer(off @ up, up)
    inside = np.linalg.norm(off, axis=1) < workspace["radius_m"] + workspace["margin_m"]  # false for NaN
    normal, offset = find_table(flat[inside], up, question["noise_m"], rng)
    height = lambda points: points @ normal + offset  # noqa: E731
    above = inside & (height(flat) > max(CLEARANCE_M, 4 * question["noise_m"]))
    normals = estimate_normals(image, np.array(question["views"][0]["X_WV"])[:3, 3]).reshape(-1, 3)
    objects = connected(image, above.reshape(image.shape[:2]))
    # Topmost first.
    objects.sort(key=lambda found: -np.quantile(height(flat[found]), 0.98))
    grasps = []
    if objects:
        grasps = list(grasps_from_above(flat[objects[0]], normals[objects[0]], normal, height,
                                        question["hand"]["opening_m"]))
        grasps = [dict(grasp, object=0) for grasp in grasps]
    return {"objects": [{"samples": [int(i) for i in found]} for found in objects], "grasps": grasps}


if __name__ == "__main__":
    print(json.dumps(detect(json.loads(sys.stdin.readline()))))

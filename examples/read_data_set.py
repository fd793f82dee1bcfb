#!/usr/bin/env python3
"""Reads the output of `rangegrasp export RESULTS -o FOLDER --clouds` with only numpy and the standard library.

    python3 examples/read_data_set.py FOLDER

prints for each cloud the number of samples of each object and the outcomes of the grasps that were tried.
"""
import json
import pathlib
import sys

import numpy as np

MEASURED = 0  # value of the field "state"; other values are shadows, dropouts and points out of view
DTYPES = {("F", "4"): "<f4", ("F", "8"): "<f8", ("U", "4"): "<u4", ("U", "1"): "u1", ("I", "4"): "<i4"}


def read_pcd(file):
    """A binary PCD as a structured array of rows x columns: x, y, z [m], label, state."""
    data = pathlib.Path(file).read_bytes()
    start = data.index(b"DATA binary\n") + len(b"DATA binary\n")
    header = dict(line.split(" ", 1) for line in data[:start].decode().splitlines() if not line.startswith("#"))
    kinds = zip(header["TYPE"].split(), header["SIZE"].split())
    dtype = [(name, DTYPES[kind]) for name, kind in zip(header["FIELDS"].split(), kinds)]
    points = np.frombuffer(data, dtype, count=int(header["POINTS"]), offset=start)
    return points.reshape(int(header["HEIGHT"]), int(header["WIDTH"]))


def pose(numbers):
    """A pose X_AB of annotations.json as a 4 x 4 array, which transforms points from B to A."""
    return np.array(numbers).reshape(4, 4)


def check(folder):
    """Ends the program if there is no data set in the folder. An export of several seeds has one in a folder for each."""
    if (folder / "annotations.json").is_file():
        return
    sets = sorted(file.parent.name for file in folder.glob("*/annotations.json"))
    cure = f"it has {', '.join(sets)}: name one of them" if sets else "name the FOLDER of `export ... -o FOLDER --clouds`"
    sys.exit(f"no annotations.json in {folder}; {cure}")


def main(folder):
    folder = pathlib.Path(folder)
    check(folder)
    data = json.loads((folder / "annotations.json").read_text())
    for cloud in data["clouds"]:
        points = read_pcd(folder / cloud["file_name"])
        points = points[points["state"] == MEASURED]
        print(f"{cloud['case']}: {cloud['outcome']}, {len(points)} samples")
        for thing in (a for a in data["annotations"] if a["cloud_id"] == cloud["id"]):
            mine = points[points["label"] == thing["label"]]
            xyz_W = np.stack([mine["x"], mine["y"], mine["z"]], axis=1)
            xyz_O = (xyz_W - pose(thing["X_WO"])[:3, 3]) @ pose(thing["X_WO"])[:3, :3]
            size_mm = 1000 * np.ptp(xyz_O, axis=0) if len(mine) else np.zeros(3)
            print(f"  {thing['name']}: {len(mine)} samples, seen {size_mm[0]:.0f} x {size_mm[1]:.0f} x "
                  f"{size_mm[2]:.0f} mm" + (", the target" if thing["target"] else ""))
        grasps = [g for g in data["grasps"] if g["cloud_id"] == cloud["id"]]
        tried = [g["outcome"] for g in grasps if g["outcome"]]
        print(f"  {len(grasps)} grasps, {sum(not g['collides'] for g in grasps)} free, tried: {', '.join(tried) or 'none'}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])

"""Perception of arrays is that of the program."""
import json
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import rangegrasp as rg


def cloud_of_a_box(noise=0.0003):
    """A table with a box of 80 x 60 x 50 mm, seen from above at an angle: rows x columns x 3, in the frame of the table."""
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(-0.2, 0.2, 0.002), np.arange(-0.2, 0.2, 0.002), indexing="ij")
    on_box = (np.abs(x) < 0.04) & (np.abs(y) < 0.03)
    return np.stack([x, y, np.where(on_box, 0.05, 0.0) + noise * rng.standard_normal(x.shape)], axis=-1)


def pose_above():
    X_WV = np.diag([1.0, -1.0, -1.0, 1.0])
    X_WV[2, 3] = 0.8
    return X_WV


def test_a_box_is_found_with_its_size():
    found = rg.perceive(cloud_of_a_box(), pose_above())
    assert len(found.objects) == 1
    assert np.allclose(found.objects[0].size, [0.08, 0.06, 0.05], atol=0.004)
    assert np.allclose(found.table_normal, [0, 0, 1], atol=0.01) and abs(found.table_offset) < 0.001
    best = found.grasps[0]
    closing = np.abs(best.X_WG[:3, 0])
    assert not best.collides and closing.max() > 0.95  # across one of the two pairs of faces
    assert abs(best.width - found.objects[0].size[closing.argmax()]) < 0.006


def test_a_list_of_points_needs_no_rows():
    points = cloud_of_a_box().reshape(-1, 3)
    found = rg.perceive(points[np.random.default_rng(2).permutation(len(points))], pose_above())
    assert len(found.objects) == 1 and len(found.grasps) > 0


def test_samples_are_positions_in_the_scan():
    scan = rg.Scene("pile", seed=42).scan()
    found = rg.perceive(scan)
    flat = scan.points.reshape(-1, 3)
    for one in found.objects:
        assert np.isfinite(flat[one.samples]).all()
        assert np.linalg.norm(flat[one.samples].mean(axis=0) - one.points.mean(axis=0)) < 0.002


def test_samples_of_a_second_view_follow_those_of_the_first():
    beside = pose_above()
    beside[0, 3] = 0.3
    views = [rg.View(cloud_of_a_box(), pose_above()), rg.View(cloud_of_a_box()[:, ::-1] + [0.0007, 0.0007, 0.0], beside)]
    found = rg.perceive(rg.Scan(views))
    assert len(found.objects) == 1
    box, flat = found.objects[0], np.concatenate([view.points.reshape(-1, 3) for view in views])
    assert len(np.unique(box.samples)) == len(box.samples)
    assert {int(sample) // views[0].points[..., 0].size for sample in box.samples} == {0, 1}
    assert np.linalg.norm(flat[box.samples] - box.points, axis=1).max() < 0.005


def test_grasps_are_those_of_the_program(tmp_path):
    import rangegrasp._core as core
    command = [sys.executable, "-m", "rangegrasp"]
    subprocess.run([*command, "scan", f"{core.data_folder()}/experiments/laser_single.yaml", "-o", tmp_path / "c.pcd"], check=True)
    told = json.loads(subprocess.run([*command, "perceive", tmp_path / "c.pcd", "--json", "--crop", "-0.25,-0.25,-1,0.25,0.25,1"],
                                     check=True, capture_output=True, text=True).stdout)
    scan = rg.Scene("single", seed=1).scan()
    scan.points[~(np.abs(scan.points[..., :2]) < 0.25).all(axis=-1)] = np.nan
    scan.radius = np.inf
    found = rg.perceive(scan)
    assert abs(len(found.objects[0].points) - told["objects"][0]["points"]) < 0.02 * told["objects"][0]["points"]
    assert np.allclose(found.objects[0].size, told["objects"][0]["size_m"], atol=0.003)
    grasps = told["objects"][0]["grasps"]
    assert abs(len(found.grasps) - len(grasps)) <= 4 and found.grasps[0].type == grasps[0]["type"]
    # perceive orders them by the predicted probability, the program by the score; X_WG includes the shift by centering, here up to 11 mm.

    def is_same(one, other):
        return (one.type == other["type"] and abs(one.width - other["width_m"]) < 0.002
                and one.approach @ np.array(other["rotation"])[:, 2] > 0.999
                and np.linalg.norm(one.X_WG[:3, 3] - other["position_m"]) < 0.02)
    assert sum(any(is_same(one, other) for one in found.grasps) for other in grasps) >= len(grasps) - 4
    best, first = found.grasps[0], grasps[0]
    assert np.linalg.norm(best.X_WG[:3, 3] - first["position_m"]) < 0.01 and abs(best.width - first["width_m"]) < 0.002


def test_a_crop_leaves_out_what_is_outside():
    points = cloud_of_a_box()
    points[:20, :20, 2] += 0.06  # a corner of the table is a thing of its own
    box = (-0.15, -0.15, -1, 0.15, 0.15, 1)
    cropped = points.copy()
    cropped[(np.abs(points[..., :2]) > 0.15).any(axis=-1)] = np.nan
    assert len(rg.perceive(points, pose_above()).objects) == 2
    one, = rg.perceive(points, pose_above(), crop=box).objects
    assert np.array_equal(one.samples, rg.perceive(cropped, pose_above()).objects[0].samples)


def test_grasps_are_ordered_by_their_score():
    scene = rg.Scene("single", seed=1)
    for found in (rg.perceive(scene.scan()), scene.perceive()):
        free = [one for one in found.grasps if not one.collides]
        assert [one.score for one in free] == sorted((one.score for one in free), reverse=True)
        assert all(one.score == one.probability and 0 < one.score < 1 for one in free)
        assert len({one.score for one in free}) > 1
    by_rules = rg.Scene("single", seed=1, set="grasp.score=rules").perceive().grasps
    assert {one.probability for one in by_rules} == {None} and by_rules[0].score > 0


def warnings_of(*arguments):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rg.perceive(*arguments)
    assert all(one.filename == __file__ for one in caught)
    return [str(one.message) for one in caught]


def test_what_makes_a_result_doubtful_is_a_warning():
    assert warnings_of(cloud_of_a_box(), pose_above()) == []
    of_unit, = warnings_of(1000 * cloud_of_a_box(), pose_above())
    assert of_unit == "the points are 2.0 m apart: points must be in metres; divide millimetres by 1000"
    no_pose, no_side = warnings_of(cloud_of_a_box())
    assert "there is no X_WV: the sensor is assumed at 0,0,0" in no_pose
    assert no_side.startswith("0,0,0 lies in the table's plane") and "up=(x, y, z)" in no_side
    assert warnings_of(cloud_of_a_box(), np.eye(4)) == [no_side]
    flat, = warnings_of(cloud_of_a_box(noise=0.0), pose_above())
    assert flat.startswith("the table is exactly flat") and "noise=" in flat
    table = cloud_of_a_box()[:75]
    no_objects, = warnings_of(table, pose_above())
    assert no_objects.startswith("no objects: ")
    assert warnings_of(rg.Scan([rg.View(table, pose_above())], radius=0.3)) == []  # of a cell


def test_zeros_are_not_measured():
    points = cloud_of_a_box()
    points[:15] = 0.0
    assert warnings_of(points, pose_above()) == ["3000 points at 0,0,0 are left out as not measured"]
    points[:15] = 0.3  # zeros in another frame
    assert warnings_of(points, pose_above()) == ["2999 points are left out: each has exactly the coordinates of another"]


def test_the_help_lists_every_segmentation():
    with pytest.raises(rg.InputError, match="must be one of") as refusal:
        rg.perceive(cloud_of_a_box(), segmentation="none")
    words = str(refusal.value).split("one of ")[1].split(", ")
    assert "convexity" in words and all(f'"{word}"' in rg.perceive.__doc__ for word in words), words


def test_errors_name_what_is_wrong():
    with pytest.raises(rg.InputError, match="100 points"):
        rg.perceive(np.zeros((5, 3)))
    with pytest.raises(ValueError, match="rows x columns x 3"):
        rg.perceive(np.zeros((5, 5, 2)))
    with pytest.raises(ValueError, match="rigid motion"):
        rg.perceive(cloud_of_a_box(), 3 * np.eye(4))
    with pytest.raises(ValueError, match=r"X_WV must be a 4 x 4 matrix, not of shape \(3,\)"):
        rg.perceive(cloud_of_a_box(), [0.8, 0, 0.62])
    with pytest.raises(ValueError, match="X_WV must be a 4 x 4 matrix of finite numbers"):
        rg.perceive(cloud_of_a_box(), np.full((4, 4), np.nan))
    for noise in (-1.0, np.nan, np.inf, 0.3):
        with pytest.raises(rg.InputError, match=f"noise {noise:g} m must be 0 to 0.05 m: is it in millimetres"):
            rg.perceive(cloud_of_a_box(), noise=noise)
    for file in ("cloud.npy", Path("cloud.npy")):
        with pytest.raises(TypeError, match=r'pass an array, e.g. np.load\("cloud.npy"\), or a Scan'):
            rg.perceive(file)
    for crop, words in (((1, 0, 0, 0, 1, 1), "crop: the first three numbers must be below"), ((0, 0, 1), "crop must be six numbers"),
                        ((5, 5, 5, 6, 6, 6), "crop: the box contains none of the 40000 points, which are from -0.2,-0.2,")):
        with pytest.raises(rg.InputError, match=words):
            rg.perceive(cloud_of_a_box(), crop=crop)
    with pytest.raises(rg.InputError, match="convexity"):
        rg.perceive(cloud_of_a_box(), segmentation="convex")
    for up in ((0, 0, 0), (0, 0, np.nan), (0, 0, np.inf), (0, 0, 1e300)):
        with pytest.raises(rg.InputError, match=r"^up must be a direction, e.g. \(0, 0, 1\), not \(0, 0, "):
            rg.perceive(cloud_of_a_box(), up=up)


@pytest.mark.parametrize(("changes", "words"), [
    ({"center": np.array([0.0, 0.0])}, "center must be three finite numbers"), ({"center": np.full(3, np.nan)}, "center must be three finite"),
    ({"radius": np.nan}, "radius must be above 0 m"), ({"radius": -1.0}, "radius must be above 0 m"),
])
def test_an_impossible_workspace_is_refused(changes, words):
    scan = rg.Scan([rg.View(cloud_of_a_box().reshape(1, -1, 3), np.eye(4))], **changes)
    with pytest.raises(ValueError, match=words):
        rg.perceive(scan)


def test_a_negative_noise_is_refused():
    points = cloud_of_a_box().reshape(1, -1, 3)
    noise = np.full(points.shape[:2], 0.0002, np.float32)
    noise[0, 7] = -0.5
    with pytest.raises(ValueError, match="noise must be 0 m or more.* not -0.5"):
        rg.perceive(rg.Scan([rg.View(points, np.eye(4), noise)]))

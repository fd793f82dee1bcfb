"""A scene gives what a trial sees and does."""
import gc
import re
import resource
import warnings
from dataclasses import replace

import numpy as np
import pytest

import rangegrasp as rg

SEED = 4711


@pytest.fixture(scope="module")
def pile():
    return rg.Scene("pile", seed=SEED)


def test_a_scan_has_points_noise_and_pose(pile):
    scan = pile.scan()
    assert scan.points.shape == (150, 512, 3) and scan.points.dtype == np.float64
    assert scan.noise.shape == scan.mask.shape == (150, 512)
    assert np.isnan(scan.points[~scan.mask]).all() and np.isfinite(scan.points[scan.mask]).all()
    assert scan.mask.mean() > 0.5
    assert np.allclose(scan.X_WV[:3, :3] @ scan.X_WV[:3, :3].T, np.eye(3))


def test_what_is_found_is_printed_in_a_line(pile):
    found = pile.perceive()
    assert repr(found) == f"Found({len(found.objects)} objects, {len(found.grasps)} grasps, noise {1e3 * found.noise:.2f} mm)"
    assert 0.1 < 1e3 * found.noise < 1.0 and len(repr(found.objects[0])) < 200


def test_scans_repeat_and_other_seeds_differ(pile):
    assert np.array_equal(pile.scan(5).points, pile.scan(5).points, equal_nan=True)
    assert not np.array_equal(pile.scan(5).points, pile.scan(6).points, equal_nan=True)


def test_a_scan_is_not_copied_and_outlives_the_scene():
    scan = rg.Scene("single", seed=SEED).scan()
    assert not scan.points.flags.owndata
    assert 0.1 < scan.mask.mean() < 1.0


def test_memory_does_not_grow_with_scans():
    scene = rg.Scene("single", seed=SEED)
    for _ in range(20):
        scene.scan()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(200):
        scene.scan()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 30_000  # KiB: fifteen scans


def test_a_grasp_delivers_and_changes_the_scene():
    scene = rg.Scene("single", seed=SEED, target="salt_cylinder")
    for grasp in scene.perceive().grasps:  # the arm does not reach each of them
        outcome = scene.grasp(grasp)
        if outcome.word != "no_path":
            break
    assert outcome.delivered and outcome.word == "delivered" and outcome.log["target"] == "salt_cylinder"
    assert scene.truth["objects"][0]["delivered"]
    assert scene.take_away() == ["salt_cylinder"] and scene.truth["objects"] == []


def test_a_grasp_of_air_finds_no_object():
    scene = rg.Scene("single", seed=SEED)
    X_WG = np.diag([1.0, -1.0, -1.0, 1.0])
    X_WG[:3, 3] = [0.05, 0.05, 0.3]
    assert scene.grasp(rg.Grasp(X_WG, 0.04)).word == "not_segmented"


@pytest.mark.parametrize("sample", [-1, 10**9])
def test_samples_are_positions_of_the_scan(pile, sample):
    grasp = pile.perceive().grasps[0]
    with pytest.raises(rg.InputError, match=f"samples of the grasp: {sample} must be 0 to "):
        pile.grasp(replace(grasp, samples=[sample]))


def test_restoring_gives_the_same_outcome_again():
    scene = rg.Scene("touching", seed=SEED)
    start = scene.save()
    grasp = scene.perceive().grasps[0]
    first = scene.grasp(grasp)
    scene.restore(start)
    scene.perceive()
    again = scene.grasp(grasp)
    assert (first.word, first.detail, first.log) == (again.word, again.detail, again.log)
    with pytest.raises(ValueError, match="another scene"):
        rg.Scene("single", seed=SEED).restore(start)


def test_a_state_is_not_that_of_a_scene_in_the_same_place():
    scene = rg.Scene("single", seed=SEED)
    start = scene.save()
    del scene
    gc.collect()
    with pytest.raises(ValueError, match="the state is of another scene"):
        rg.Scene("single", seed=SEED + 1).restore(start)


def test_own_objects_stand_where_they_are_put():
    pose = np.eye(4)
    pose[:3, 3] = [0.03, -0.02, 0.08]
    scene = rg.Scene(objects={"coffee_cup": pose}, seed=SEED)
    only = scene.truth["objects"][0]
    assert only["name"] == "coffee_cup" and np.allclose(only["pose"][:2, 3], pose[:2, 3], atol=0.02)
    labels = scene.scan() and scene.truth["labels"][0]
    assert (labels == only["label"]).sum() > 500


def settling_warnings(*objects):
    """Of objects at heights from which each alone drops straight down."""
    poses = []
    for name, x, y, z in objects:
        poses.append((name, np.eye(4)))
        poses[-1][1][:3, 3] = x, y, z
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rg.Scene(objects=poses, seed=SEED)
    assert all(one.filename == __file__ for one in caught)
    return [str(one.message) for one in caught]


def test_poses_that_no_object_keeps_are_warnings():
    assert settling_warnings(("coffee_cup", -0.08, 0.0, 0.08), ("coffee_cup", 0.08, 0.0, 0.06)) == []
    assert settling_warnings(("coffee_cup", 2.0, 0.0, 0.08)) == ["coffee_cup has settled outside the workspace, at x, y = 2.00, 0.00 m"]
    inside = settling_warnings(("dextrose", 0.0, 0.0, 0.08), ("salt_cuboid", 0.01, 0.0, 0.08))
    assert inside[0] == "dextrose and salt_cuboid overlap at the given poses"
    # It falls on the cup's edge and tips over.
    line, = settling_warnings(("coffee_cup", 0.0, 0.0, 0.05), ("salt_cuboid", 0.05, 0.0, 0.2))
    assert re.fullmatch(r"salt_cuboid has settled \d+ mm to the side of the given pose", line)


def test_a_box_is_turned_with_its_object():
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]
    scene = rg.Scene(objects={"salt_cuboid": pose}, seed=SEED)
    scan = scene.scan()
    one, same = scene.perceive().objects[0], rg.perceive(scan).objects[0]
    assert np.allclose(one.size, same.size, atol=0.003) and np.allclose(one.center, same.center, atol=0.003)
    x, y = np.ptp(one.points[:, :2], axis=0)  # the box along the axes of W is larger
    assert one.size[1] < 0.9 * min(x, y) and one.size[0] >= one.size[1]


def test_a_picture_shows_the_scene(pile):
    picture = pile.render("overview", 320, 240)
    assert picture.shape == (240, 320, 3) and picture.dtype == np.uint8 and picture.std() > 10


@pytest.mark.parametrize(("make", "error", "words"), [
    (lambda: rg.Scene("pil"), rg.InputError, "nearest"),
    (lambda: rg.Scene("seam_base"), rg.InputError, "seam|grasping"),
    (lambda: rg.Scene("single", target="cofee_cup"), rg.InputError, "coffee_cup"),
    (lambda: rg.Scene("single", set=["physics.timestep=1"]), rg.InputError, "timestep_ms"),
    (lambda: rg.Scene("single", set="physics.timestep=1"), rg.InputError, "timestep_ms"),
    (lambda: rg.Scene(objects={"cup": np.eye(4)}), rg.InputError, "cup"),
    (lambda: rg.Scene(objects={"cofee_cup": np.eye(4)}), rg.InputError, "no object 'cofee_cup' .*'coffee_cup'"),
    (lambda: rg.Scene(objects={"coffee_cup": [0.0, 0.0, 0.1]}), ValueError, "pose of coffee_cup must be a 4 x 4 matrix"),
    (lambda: rg.Scene(objects={"coffee_cup": 2 * np.eye(4)}), ValueError, "rigid motion"),
    (lambda: rg.Scene(objects=["beaker"]), ValueError, "X_WO a 4 x 4 matrix"),
    (lambda: rg.Scene(objects=[("beaker",)]), ValueError, "X_WO a 4 x 4 matrix"),
    (lambda: rg.Scene(target="spread", objects={"coffee_cup": np.eye(4)}), ValueError, "arrangement"),
    (lambda: rg.Scene("single").grasp(rg.Grasp(np.eye(3), 0.05)), ValueError, "4 x 4"),
    (lambda: rg.Scene("single").grasp(rg.perceive), TypeError, "grasp must be one Grasp, e.g. .*, not function"),
    (lambda: rg.Scene("single").render("nowhere"), rg.InputError, "overview"),
    (lambda: rg.Scene("single").render(width=10**6, height=10**6), rg.InputError, "1 to 8192 pixels, not 1000000 and 1000000"),
    (lambda: rg.Scene("single").render(width=0), rg.InputError, "1 to 8192 pixels, not 0 and 480"),
    (lambda: rg.Scene("single").render("nan,0,0,0,0,0"), rg.InputError, "nan,0,0,0,0,0"),
])
def test_errors_name_what_is_wrong(make, error, words):
    with pytest.raises(error, match=words):
        make()

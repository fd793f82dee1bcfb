"""A score that is trained on a data set is the same again, is calibrated on what it did not see, and ranks grasps in a run."""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rangegrasp as rg

pytest.importorskip("lightgbm")
SCRIPT = Path(__file__).resolve().parents[2] / "scripts/train-grasp-score"


def made_up(folder, grasps=1200):
    """Grasps that are delivered where the ways of the fingers are free."""
    rng = np.random.default_rng(5)
    names = rg.feature_names()
    features = rng.random((grasps, len(names))).astype(np.float32)
    free = features[:, names.index("fingers_way_free")]
    delivered = rng.random(grasps) < 0.1 + 0.8 * (free > 0.5)
    scenes = np.repeat(np.arange(grasps // 6), 6)
    folder.mkdir()
    np.savez(folder / "shard-00000.npz", features=features, scene=scenes, target=np.array(["a"] * (grasps // 6)),
             outcome=np.where(delivered, "delivered", "not_lifted"), object=np.array(["a", "b", "c"] * (grasps // 3)))
    (folder / "card.json").write_text(json.dumps({"made_by": "test", "experiment": "none", "set": [], "seed": 0, "scenes": grasps // 6,
                                                  "feature_names": names}))
    return folder


def train(data, out):
    return subprocess.run([sys.executable, SCRIPT, data, "-o", out, "--rounds", "40"], capture_output=True, text=True)


def test_training_finds_what_decides_and_repeats(tmp_path):
    data = made_up(tmp_path / "data")
    assert train(data, tmp_path / "a.json").returncode == 0
    assert train(data, tmp_path / "b.json").returncode == 0
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    card = json.loads((tmp_path / "a.json").read_text())["card"]
    assert next(iter(card["importance"])) == "fingers_way_free"
    assert card["brier"]["scenes held out"] < 0.15 < card["brier"]["constant"]
    best = card["best grasp of a scene delivered"]
    assert best["rules"] + 0.1 < best["learned, scenes held out"] <= best["any"]


def test_the_script_collects_what_the_shipped_score_is_trained_on(tmp_path):
    ran = subprocess.run([sys.executable, SCRIPT.with_name("collect-grasps"), tmp_path, "--seeds", "33", "--jobs", "1", "--short"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert sorted(folder.name for folder in tmp_path.iterdir()) == ["box_33_0", "objects_33", "pile_33_0", "touching_33_0"]
    outcomes = []
    for folder in tmp_path.glob("*_33_0"):
        card = json.loads((folder / "card.json").read_text())
        assert card["feature_names"] == rg.feature_names() and any("objects_33" in one for one in card["set"])
        with np.load(folder / "shard-00000.npz") as shard:
            assert np.isfinite(shard["features"]).all()
            assert set(shard["object"]) <= {one.name for one in (tmp_path / "objects_33").iterdir()} | {""}
            outcomes += list(shard["outcome"])
    assert "delivered" in outcomes


def test_a_model_ranks_the_grasps_of_a_run(tmp_path):
    names = rg.feature_names()
    tree = [[names.index("workspace_distance"), 0.05, 1, 2], [2.0], [-2.0]]
    (tmp_path / "model.json").write_text(json.dumps({"features": names, "base": 0.0, "trees": [tree]}))
    chosen = dict(trials=1, objects=["coffee_cup", "dextrose"], seed=4711, progress=False)
    results = rg.evaluate(None, "single", set=[f"grasp.score_model={tmp_path / 'model.json'}"], **chosen)
    for row in results.rows:
        assert round(row["data"]["log"]["grasp"]["probability"], 4) in (round(1 / (1 + np.exp(2.0)), 4), round(1 / (1 + np.exp(-2.0)), 4))
    shipped = rg.evaluate(None, "single", **chosen)
    assert all(0 < row["data"]["log"]["grasp"]["probability"] < 1 for row in shipped.rows)
    for by_rules in ("grasp.score=rules", "method=published"):
        rows = rg.evaluate(None, "single", set=[by_rules], **chosen).rows
        assert all("probability" not in row["data"]["log"].get("grasp", {}) for row in rows if row["data"].get("log"))
    for values, reason in ((["grasp.score_model=nowhere.json"], "nowhere.json"),
                           (["grasp.score=rules", f"grasp.score_model={tmp_path / 'model.json'}"], "score: learned")):
        with pytest.raises(rg.InputError, match=reason):
            rg.evaluate(None, "single", set=values, **chosen)


def change(data, **arrays):
    with np.load(data / "shard-00000.npz") as shard:
        changed = {name: shard[name] for name in shard.files}
    for name, of in arrays.items():
        changed[name] = of(changed[name])
    np.savez(data / "shard-00000.npz", **changed)


@pytest.mark.parametrize(("arrays", "words"), [
    ({"features": lambda a: a * np.nan}, "features must be finite numbers"), ({"features": lambda a: a[:, :5]}, "features are of (60, 5)"),
    ({"features": lambda a: a[:-1]}, "features are of (59, "), ({"scene": lambda a: a - 5}, "scene must be 0 to 9"),
    ({"outcome": lambda a: np.char.capitalize(a)}, "outcome 'Delivered' must be one of delivered, ")])
def test_values_that_cannot_be_are_refused(tmp_path, arrays, words):
    data = made_up(tmp_path / "data", 60)
    change(data, **arrays)
    ran = train(data, tmp_path / "m.json")
    assert ran.returncode == 1 and ran.stderr.startswith(f"scripts/train-grasp-score: {data}/shard-00000.npz: is not a whole shard"), ran.stderr
    assert words in ran.stderr


@pytest.mark.parametrize("name", ["card.json", "shard-00000.npz"])
def test_a_damaged_file_is_named(tmp_path, name):
    data = made_up(tmp_path / "data", 60)
    whole = (data / name).read_bytes()
    for damaged in (b"", b"{}", b"\xff\xfe", whole[:len(whole) // 2]):
        (data / name).write_bytes(damaged)
        ran = train(data, tmp_path / "m.json")
        assert ran.returncode == 1 and ran.stderr.startswith(f"scripts/train-grasp-score: {data / name}: is not "), ran.stderr
    (data / name).unlink()
    ran = train(data, tmp_path / "m.json")
    assert ran.returncode == 1 and "rangegrasp.collect writes data sets" in ran.stderr and "Traceback" not in ran.stderr


def test_too_few_grasps_are_refused(tmp_path):
    told = train(made_up(tmp_path / "data", 60), tmp_path / "m.json")
    assert told.returncode == 1 and "collect at least 200 in total, some delivered and some not" in told.stderr
    told = train(tmp_path, tmp_path / "m.json")
    assert told.returncode == 1 and "card.json" in told.stderr

"""A data set does not depend on how it was made."""
import json
import shutil

import numpy as np
import pytest

import rangegrasp as rg


def arrays_of(folder):
    found = {}
    for file in sorted(folder.glob("shard-*.npz")):
        with np.load(file) as shard:
            found[file.name] = {name: shard[name] for name in shard.files}
    return found


def same(a, b):
    assert a.keys() == b.keys()
    for name in a:
        for key in a[name]:
            assert np.array_equal(a[name][key], b[name][key], equal_nan=key == "points"), (name, key)


SMALL = dict(experiment="touching", scenes=4, grasps=3, seed=4711, scenes_per_shard=2)
TWO = {**SMALL, "scenes": 2}


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """The folder of the first two of these scenes; not to be changed."""
    return rg.collect(tmp_path_factory.mktemp("two") / "d", jobs=1, **TWO)


def test_jobs_and_stops_do_not_change_it(tmp_path, two):
    whole = arrays_of(rg.collect(tmp_path / "two", jobs=2, **SMALL))
    first = arrays_of(two)["shard-00000.npz"]
    again = arrays_of(rg.collect(shutil.copytree(two, tmp_path / "one"), jobs=1, **SMALL))
    same(whole, again)
    assert np.array_equal(first["X_WG"], again["shard-00000.npz"]["X_WG"])
    shard = whole["shard-00001.npz"]
    assert shard["points"].shape[0] == len(shard["target"]) == 2
    assert len(shard["X_WG"]) == len(shard["outcome"]) == len(shard["scene"]) <= 6
    assert set(shard["outcome"]) <= {"delivered", "no_path", "not_lifted", "dropped", "misplaced", "invalid_physics", "no_grasp"}


@pytest.mark.parametrize("jobs", [1, 2])
def test_progress_counts_the_scenes_of_all_processes(tmp_path, capsys, monkeypatch, jobs):
    monkeypatch.setattr("rangegrasp._collect._QUIET_S", 0.0)
    rg.collect(tmp_path / "d", jobs=jobs, **{**SMALL, "scenes": 2, "grasps": 1, "scenes_per_shard": 1})
    assert capsys.readouterr().err.splitlines()[-1] == "progress: 2/2 scenes, 0 s left"


def test_more_scenes_fill_the_last_shard(tmp_path, two):
    rg.collect(tmp_path / "d", jobs=1, **{**SMALL, "scenes": 1})
    again = arrays_of(rg.collect(tmp_path / "d", jobs=1, **TWO))
    assert len(again["shard-00000.npz"]["target"]) == 2
    same(again, arrays_of(two))
    with pytest.raises(rg.InputError, match="has 2 scenes"):
        rg.collect(tmp_path / "d", jobs=1, **{**SMALL, "scenes": 1})


@pytest.mark.parametrize(("card", "words"), [(b"", "is not JSON"), (b"{", "is not JSON"), (b"\xff\xfe", "is not JSON"), (b"\x80", "is not JSON"),
                                             (b"[]", "is not the card"), (b"null", "is not the card"), (b'{"scenes": "4"}', "is not the card")])
def test_a_damaged_card_is_named(tmp_path, card, words):
    (tmp_path / "card.json").write_bytes(card)
    with pytest.raises(rg.InputError, match=f"card.json: {words}.*another data set elsewhere"):
        rg.collect(tmp_path, jobs=1, **SMALL)


def test_the_card_describes_every_array(two):
    card = json.loads((two / "card.json").read_text())
    assert set(card["fields"]) == set(arrays_of(two)["shard-00000.npz"])
    with pytest.raises(rg.InputError, match="seed is 4711"):
        rg.collect(two, jobs=1, **{**TWO, "seed": 5})

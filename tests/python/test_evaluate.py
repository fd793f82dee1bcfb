"""A function as a detector is scored like any other, whatever it does."""
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np
import pytest

import rangegrasp as rg
from rangegrasp import _core

SEED = 4711
FEW = dict(trials=1, objects=["coffee_cup", "salt_cuboid", "dextrose"], seed=SEED, progress=False)


def built_in(scan):
    found = rg.perceive(scan, grasped=1)
    return rg.Detection([g for g in found.grasps if g.object == 0 and not g.collides], [one.samples for one in found.objects])


def without_times(results):
    return [{key: value for key, value in row.items() if key != "seconds"} for row in results.rows]


@pytest.fixture(scope="module")
def own():
    """Of the built-in method."""
    return rg.evaluate(None, "single", jobs=2, **FEW)


@pytest.fixture(scope="module")
def of_function(tmp_path_factory):
    """Of the same method as a function."""
    return rg.evaluate(built_in, "single", jobs=2, out=tmp_path_factory.mktemp("of_function") / "r", **FEW)


def test_the_built_in_method_gives_the_program_s_records(tmp_path, own):
    subprocess.run([sys.executable, "-m", "rangegrasp", "run", "laser_single", "--trials", "1", "--objects",
                    "coffee_cup,salt_cuboid,dextrose", "--seed", str(SEED), "--out", tmp_path / "cli"], check=True, capture_output=True)
    expected = without_times(rg.load(tmp_path / "cli"))
    for results in (own, rg.evaluate(None, "single", jobs=1, **FEW)):
        assert without_times(results) == expected


def test_a_function_delivers_and_does_not_depend_on_the_number_of_jobs(of_function):
    one = rg.evaluate(built_in, "single", jobs=1, **FEW)
    assert without_times(one) == without_times(of_function)
    assert [row["outcome"] for row in one.rows].count("delivered") >= 2
    assert "Coffee" in one.table() and one.table("csv").count("\n") > 3


def test_a_batch_in_this_process_answers_the_same(of_function):
    process, sizes = os.getpid(), []

    def batch(scans):
        assert os.getpid() == process
        sizes.append(len(scans))
        return [built_in(scan) for scan in scans]
    batched = rg.evaluate(batch, "single", jobs=2, batch=2, **FEW)
    same = [{key: row[key] for key in ("id", "outcome", "detail")} for row in of_function.rows]
    assert same == [{key: row[key] for key in ("id", "outcome", "detail")} for row in batched.rows]
    assert sum(sizes) == 3 and max(sizes) <= 2


def test_batches_leave_no_descriptor_open():
    def open_after_a_run():
        rg.evaluate(lambda scans: [[] for _ in scans], "single", batch=1, trials=1, objects=["salt_cuboid"], seed=SEED, progress=False)
        return len(os.listdir("/proc/self/fd"))
    assert len({open_after_a_run() for _ in range(3)}) == 1


def test_a_refused_run_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for batch in (None, 1):
        with pytest.raises(rg.InputError, match="nearest"):
            rg.evaluate(lambda scans: [], "pille", batch=batch, progress=False)
        assert list(tmp_path.iterdir()) == []


def test_a_detector_sees_the_scan_of_the_scene():
    seen = []

    def batch(scans):
        seen.extend((scan.seed, scan.noise_m, np.array(scan.points)) for scan in scans)
        return [[] for _ in scans]
    rg.evaluate(batch, "single", batch=1, trials=1, objects=["salt_cuboid"], seed=SEED, progress=False)
    scan = rg.Scene("single", seed=SEED, target="salt_cuboid").scan()
    assert [scan.seed, scan.noise_m] == list(seen[0][:2]) and scan.seed < 2**53 and 1e-4 < scan.noise_m < 1e-3
    assert np.array_equal(scan.points, seen[0][2], equal_nan=True)


def loop(scan):
    while True:
        pass


def fail(scan):
    raise KeyError("no such weight")


WRONG = [
    (fail, "detector_failed", "no such weight"),
    (lambda scan: [rg.Grasp(np.full((4, 4), np.nan), 0.05)], "detector_failed", "NaN"),
    (lambda scan: [rg.Grasp(np.eye(3), 0.05)], "detector_failed", "4 x 4|shape"),
    (lambda scan: [rg.Grasp(2 * np.eye(4), 0.05)], "detector_failed", "rotation"),
    (lambda scan: rg.Detection([], [[10**9]]), "detector_failed", "position of a sample"),
    (lambda scan: rg.Detection([], [scan.mask]), "detector_failed", "TypeError: objects must be positions of samples, e.g. np.flatnonzero"),
    (lambda scan: 7, "detector_failed", "list of Grasp"),
    (lambda scan: [np.zeros((50_000, 50_000)) + 1.0], "detector_failed", "MemoryError|memory"),
    (loop, "detector_failed", "time"),
    (lambda scan: os._exit(3), "crashed", "code 3"),
    (lambda scan: os.kill(os.getpid(), signal.SIGSEGV), "crashed", "Segmentation"),
    (lambda scan: [], "not_segmented", ""),
]


def test_what_a_function_does_wrong_fails_its_trial_alone(tmp_path):
    detectors = [built_in, *(detect for detect, _, _ in WRONG), built_in]

    def in_turn(scan):
        asked = len(list(tmp_path.iterdir()))  # in this run, one after the other
        (tmp_path / str(asked)).touch()
        return detectors[asked](scan)
    rows = rg.evaluate(in_turn, "single", trials=len(detectors), objects=["salt_cuboid"], seed=SEED, jobs=1, time_limit=2.0, progress=False).rows
    for row, (_, outcome, words) in zip(rows[1:-1], WRONG, strict=True):
        assert row["outcome"] == outcome and re.search(words, row["detail"]), (outcome, words, row["outcome"], row["detail"])
    assert "delivered" in (rows[0]["outcome"], rows[-1]["outcome"])


def test_what_hangs_beyond_python_is_killed_at_the_trial_s_limit(tmp_path):
    def hang(scan):
        (tmp_path / "asked").touch()
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})  # time_limit's handler does not run
        time.sleep(60)
        (tmp_path / "answered").touch()
    results = rg.evaluate(hang, "single", trials=1, objects=["coffee_cup"], seed=SEED, time_limit=1.0, progress=False,
                          set=["trial_limit_s=3"])
    assert results.rows[0]["outcome"] == "timed_out"
    assert [file.name for file in tmp_path.iterdir()] == ["asked"]


def test_runs_are_compared_case_by_case(own):
    second = rg.evaluate(lambda scan: [], "single", **FEW)
    compared = own.compare(second)
    assert compared["pairs"] == 3 and compared["only_second"] == 0
    assert compared["only_first"] == sum(row["outcome"] == "delivered" for row in own.rows)
    with pytest.raises(TypeError, match=r"other must be Results, e.g. rg.load\(folder\), not 'v2'"):
        own.compare("v2")
    with pytest.warns(UserWarning, match="different experiments"):
        own.compare(rg.evaluate(lambda scan: [], "single", set=["name=other"], **FEW))


def test_records_are_a_data_frame(own):
    pandas = pytest.importorskip("pandas")
    records = own.records
    assert isinstance(records, pandas.DataFrame) and len(records) == 3
    assert (records.seed > 0).all()
    assert {"id", "outcome", "data.log.lift_height_m", "seconds.trial"} <= {*records.columns}


def test_results_are_kept_resumed_and_not_mixed(tmp_path, of_function):
    shutil.copytree(of_function.folder, tmp_path / "r")
    with pytest.raises(rg.InputError, match="resume=True continues them, overwrite=True deletes them, out=... writes elsewhere") as refusal:
        rg.evaluate(built_in, "single", out=tmp_path / "r", **FEW)
    assert "--" not in str(refusal.value)
    again = rg.evaluate(built_in, "single", out=tmp_path / "r", resume=True, **{**FEW, "trials": 2})
    assert len(again.rows) == 6
    with pytest.raises(rg.InputError, match="detector.*another folder with out=..., or use overwrite=True [(]resume=True can only"):
        rg.evaluate(lambda scan: [], "single", out=tmp_path / "r", resume=True, **{**FEW, "trials": 2})
    with pytest.raises(rg.InputError, match="resume=True continues existing results, overwrite=True deletes them"):
        rg.evaluate(built_in, "single", out=tmp_path / "r", resume=True, overwrite=True, **FEW)
    with pytest.raises(rg.InputError, match="no results"):
        rg.load(tmp_path / "nothing")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(rg.InputError, match="loop: Too many levels of symbolic links"):
        rg.load(tmp_path / "loop")


def test_a_report_needs_the_function_of_its_run(tmp_path):
    results = rg.evaluate(lambda scan: [], "single", out=tmp_path / "r", trials=1, objects=["salt_cuboid"], seed=SEED, progress=False)
    assert results.report().is_file()
    with pytest.raises(rg.InputError, match="r: the detector was the Python function"):
        rg.load(tmp_path / "r").report()


def test_ctrl_c_leaves_a_store_to_resume_and_no_process(tmp_path, monkeypatch):
    # With a folder ASKED, it answers the first two questions, and is then busy until it is interrupted.
    (tmp_path / "patient.py").write_text(
        "import os, tempfile, time\nimport rangegrasp as rg\n\ndef detect(scan):\n"
        "    asked = os.environ.get('ASKED')\n"
        "    if asked:\n        tempfile.mkstemp(dir=asked)\n        time.sleep(600 if len(os.listdir(asked)) > 2 else 0)\n"
        "    return [g for g in rg.perceive(scan, grasped=1).grasps if g.object == 0]\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "asked").mkdir()
    import patient
    code = ("import rangegrasp as rg, patient, sys\n"
            f"rg.evaluate(patient.detect, 'single', seed={SEED}, trials=2, objects=['spread', 'dextrose'], jobs=2, out=sys.argv[1], progress=False, time_limit=600)\n")
    process = subprocess.Popen([sys.executable, "-c", code, tmp_path / "r"], stderr=subprocess.PIPE, text=True, start_new_session=True,
                               env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "ASKED": str(tmp_path / "asked")})
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        time.sleep(0.2)
        try:
            if len(rg.load(tmp_path / "r").rows) >= 2:
                break
        except ValueError:
            continue
    os.killpg(process.pid, signal.SIGINT)
    error = process.communicate(timeout=30)[1]
    assert "KeyboardInterrupt" in error
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    kept = len(rg.load(tmp_path / "r").rows)
    assert kept == 2
    whole = dict(seed=SEED, trials=2, objects=["spread", "dextrose"], jobs=2, progress=False, time_limit=600)
    done = rg.evaluate(patient.detect, "single", out=tmp_path / "r", resume=True, **whole)
    assert without_times(done) == without_times(rg.evaluate(patient.detect, "single", out=tmp_path / "anew", **whole))
    assert "delivered" in [row["outcome"] for row in done.rows]


def test_a_single_word_stands_for_a_list_of_one():
    one = rg.evaluate(None, "single", **{**FEW, "objects": "salt_cuboid"}, set="stop_after=7")
    assert [row["group"] for row in one.rows] == ["salt_cuboid"]


def test_without_pandas_records_name_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'rangegrasp\[pandas\]'"):
        rg.Results(tmp_path).records


def test_wrong_use_is_refused():
    with pytest.raises(TypeError, match="detect must be a function of a Scan, or None, not 'det.py'"):
        rg.evaluate("det.py", "pille", progress=False)
    with pytest.raises(rg.InputError, match="nearest"):
        rg.evaluate(None, "pille", progress=False)
    with pytest.raises(rg.InputError, match="evaluate"):
        _core.run("laser_single", ["detector=python"], 1, [], [], "/nonexistent", 1, False, False, None, "", lambda *_: None)

"""Data sets: scans, candidate grasps, and what came of them."""
from __future__ import annotations

import json
import multiprocessing
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, wait
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np

from . import _core
from ._scene import Scene, experiment_file, words_of

FIELDS = {
    "points": "(scenes, rows, columns, 3) float32 [m]: the scan in W, NaN where nothing was measured",
    "X_WV": "(scenes, 4, 4): pose of the sensor in W",
    "target": "(scenes,) text: the object that the arrangement was drawn for; ground truth",
    "index": "(scenes,) int: of the trial of that object",
    "scene": "(grasps,) int: position of the grasp's scene in this file",
    "X_WG": "(grasps, 4, 4): frame of the grasp, x the closing direction, z out of the hand",
    "approach": "(grasps, 3): unit vector of the straight approach",
    "width": "(grasps,) [m]: expected width between the closed pads",
    "score": "(grasps,): of the built-in method, which orders by it: predicted probability of delivery or, with grasp.score=rules, of the rules",
    "features": "(grasps, features) float32: what is known of the grasp from the scan; the card's feature_names",
    "outcome": "(grasps,) text: delivered, no_grasp, no_path, not_lifted, dropped, misplaced or invalid_physics",
    "object": "(grasps,) text: the object that the grasp was at; ground truth",
}

_QUIET_S = 30.0  # minimum time between two lines of progress, as of `rangegrasp run`
_LOOK_S = 1.0  # period at which other processes' scenes are counted

_done: Any = None  # in a worker process: the number of scenes that all workers have done


def _progress(scenes: int) -> Callable[[int], None]:
    begun = shown = time.monotonic()

    def show(done: int) -> None:
        nonlocal shown
        now = time.monotonic()
        if done == 0 or now - shown < _QUIET_S:
            return
        shown = now
        print(f"progress: {done}/{scenes} scenes, {(scenes - done) * (now - begun) / done:.0f} s left", file=sys.stderr, flush=True)
    return show


def _begin_worker(done: Any) -> None:
    global _done
    _done = done


def _count_scene() -> None:
    with _done.get_lock():
        _done.value += 1


def _collect_scene(experiment: str, seed: int, target: str, index: int, grasps: int, set: Sequence[str]) -> dict[str, Any] | None:
    try:
        scene = Scene(experiment, seed, target=target, index=index, set=set)
    except _core.RunError:  # no arrangement came to rest in view
        return None
    scan = scene.scan()
    found = scene.perceive(features=True)
    free = [i for i, grasp in enumerate(found.grasps) if not grasp.collides]
    chosen = np.random.default_rng(scene.seed).permutation(len(free))[:grasps]
    start = scene.save()
    tried = []
    for number, i in enumerate(chosen):
        if number > 0:
            scene.restore(start)
        grasp = found.grasps[free[i]]
        outcome = scene.grasp(grasp)
        features = found.features[free[i]] if found.features is not None else []
        tried.append((grasp, features, outcome.word, outcome.log["target"] or ""))
    return {"points": scan.points.astype(np.float32), "X_WV": scan.X_WV, "target": target, "index": index, "tried": tried}


def _write_shard(file: Path, jobs: list[tuple[Any, ...]], count: Callable[[], None] = _count_scene) -> int:
    scenes = []
    for job in jobs:
        scene = _collect_scene(*job)
        count()
        if scene is not None:
            scenes.append(scene)
    tried = [(i, *one) for i, scene in enumerate(scenes) for one in scene["tried"]]
    grasps = [one[1] for one in tried]
    shape = scenes[0]["points"].shape if scenes else (0, 0, 3)
    arrays = {
        "points": np.array([scene["points"] for scene in scenes], np.float32).reshape(len(scenes), *shape),
        "X_WV": np.array([scene["X_WV"] for scene in scenes]).reshape(-1, 4, 4),
        "target": np.array([scene["target"] for scene in scenes], dtype=np.str_),
        "index": np.array([scene["index"] for scene in scenes], dtype=np.int64),
        "scene": np.array([one[0] for one in tried], dtype=np.int64),
        "X_WG": np.array([grasp.X_WG for grasp in grasps]).reshape(-1, 4, 4),
        "approach": np.array([grasp._approach for grasp in grasps]).reshape(-1, 3),
        "width": np.array([grasp.width for grasp in grasps], dtype=np.float64),
        "score": np.array([grasp.score for grasp in grasps], dtype=np.float64),
        "features": np.array([one[2] for one in tried], np.float32).reshape(-1, len(_core.feature_names())),
        "outcome": np.array([one[3] for one in tried], dtype=np.str_),
        "object": np.array([one[4] for one in tried], dtype=np.str_),
    }
    partial = file.with_suffix(f".{os.getpid()}.part")
    with open(partial, "wb") as stream:
        np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
    partial.rename(file)
    return len(grasps)


def _read_card(file: Path) -> dict[str, Any]:
    cure = "restore it, or write another data set elsewhere"
    try:
        card = json.loads(file.read_bytes())
    except ValueError as error:  # also of bytes that are no text
        raise _core.InputError(f"{file}: is not JSON ({error}): {cure}") from error
    if not isinstance(card, dict) or not isinstance(card.get("scenes"), int):
        raise _core.InputError(f"{file}: is not the card of a data set, an object with the number of `scenes`: {cure}")
    return card


def _make_room(folder: Path, before: int, scenes: int, scenes_per_shard: int) -> None:
    """For more scenes than before, removes the last shard if it is not full, so that it is made again with them."""
    if scenes < before:
        raise _core.InputError(f"{folder}: has {before} scenes, more than {scenes}: give scenes={before} or more, or another folder")
    if scenes > before and before % scenes_per_shard != 0:
        (folder / f"shard-{before // scenes_per_shard:05d}.npz").unlink(missing_ok=True)


def _write_shards(tasks: list[tuple[Path, list[tuple[Any, ...]]]], processes: int) -> None:
    show = _progress(sum(len(jobs) for _, jobs in tasks))
    if processes == 1:
        done = 0

        def count() -> None:
            nonlocal done
            done += 1
            show(done)
        for task in tasks:
            _write_shard(*task, count)
        return
    # Forked, as trials are: a script of the caller's need not be one that can be imported.
    context = multiprocessing.get_context("fork")
    number = context.Value("i", 0)
    with ProcessPoolExecutor(processes, context, _begin_worker, (number,)) as pool:
        shards = [pool.submit(_write_shard, *task) for task in tasks]
        try:
            left = set(shards)
            while left:
                ended, left = wait(left, _LOOK_S)
                for shard in ended:
                    shard.result()
                show(number.value)
        finally:
            for shard in shards:
                shard.cancel()


def collect(out: str | os.PathLike[str], experiment: str = "pile", *, scenes: int = 100, grasps: int = 8, seed: int = 1,
            scenes_per_shard: int = 20, jobs: int | None = None, set: str | Sequence[str] = ()) -> Path:
    """Executes several candidate grasps in each of many scenes, each from the same settled state, and writes what came of them.

    Candidates are drawn evenly from the built-in method's free grasps of the topmost object. The folder holds `shard-00000.npz`, ...
    and `card.json`, which describes the arrays; NumPy alone reads them. Shards that are there are not made again, so that the same call
    goes on with a run that was stopped. Neither the number of jobs nor a stop changes a shard. With more `scenes` than before, the last
    shard is made again if it was not full. A long run shows its progress on stderr, at most one line in 30 s.

    Parameters
    ----------
    out : path
        Folder of the data set.
    experiment : str or path
        As for `Scene`; its objects are taken in turn.
    scenes, grasps : int
        How many scenes, not fewer than the folder has, and at most how many grasps in each.
    seed : int
    scenes_per_shard : int
    jobs : int, optional
        Processes; the number of cores if not given.
    set : str or sequence of str
        Keys of the experiment to change.

    Returns
    -------
    Path
        Of the folder.

    Raises
    ------
    InputError
        For an unknown experiment, or a folder with a data set that was made otherwise.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    settings = words_of(set)
    names = _core.objects(experiment_file(experiment), settings)
    card = {"made_by": f"rangegrasp {_core.version()}", "experiment": str(experiment), "set": settings, "seed": seed, "scenes": scenes,
            "grasps_per_scene": grasps, "scenes_per_shard": scenes_per_shard, "fields": FIELDS, "feature_names": _core.feature_names()}
    file = folder / "card.json"
    if file.exists():
        before = _read_card(file)
        for key in ("made_by", "experiment", "set", "seed", "grasps_per_scene", "scenes_per_shard"):
            if before.get(key) != card[key]:
                raise _core.InputError(f"{file}: {key} is {before.get(key)!r}, not {card[key]!r}: write another data set elsewhere")
        _make_room(folder, before["scenes"], scenes, scenes_per_shard)
    file.write_text(json.dumps(card, indent=2) + "\n")
    tasks = []
    for number, first in enumerate(range(0, scenes, scenes_per_shard)):
        shard = folder / f"shard-{number:05d}.npz"
        if shard.exists():
            continue
        numbers = range(first, min(first + scenes_per_shard, scenes))
        tasks.append((shard, [(experiment, seed, names[i % len(names)], i // len(names), grasps, settings) for i in numbers]))
    if tasks:
        _write_shards(tasks, jobs or os.cpu_count() or 1)
    return folder

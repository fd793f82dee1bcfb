"""Experiments, with a detector that is a Python function."""
from __future__ import annotations

import contextlib
import hashlib
import inspect
import json
import logging
import os
import pickle
import resource
import selectors
import shutil
import signal
import socket
import struct
import sys
import tempfile
import threading
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Iterator, Sequence

import numpy as np

from . import _core
from ._scene import experiment_file, words_of
from ._types import Detection, Found, Grasp, Scan, _positions

if TYPE_CHECKING:
    import pandas

Answer = Detection | Found | Sequence[Grasp]
Detect = Callable[[Scan], Answer]
DetectBatch = Callable[[list[Scan]], Sequence[Answer]]

_MEGA = 1 << 20


def _answer(found: Any) -> str:
    """The answer of docs/bring-your-own-detector.md. C++ checks values, here only what JSON cannot hold."""
    objects: list[Any] | None = None
    if isinstance(found, (Detection, Found)):
        grasps = list(found.grasps)
        if isinstance(found, Found):
            objects = [one.samples for one in found.objects]
        elif found.objects is not None:
            objects = list(found.objects)
    elif isinstance(found, (list, tuple)):
        grasps = list(found)
    else:
        raise TypeError(f"a detector returns a list of Grasp or a Detection, not {type(found).__name__}")
    for i, grasp in enumerate(grasps):
        if not isinstance(grasp, Grasp):
            raise TypeError(f"grasps[{i}] is no Grasp but {type(grasp).__name__}")
        values = [*np.ravel(grasp.X_WG), grasp.width, *grasp._approach, grasp.score]
        if not np.isfinite(np.asarray(values, dtype=float)).all():
            raise ValueError(f"grasps[{i}] holds NaN or an infinity: {grasp}")
    answer: dict[str, Any] = {"grasps": [grasp._json() for grasp in grasps]}
    if objects is not None:
        answer["objects"] = [{"samples": _positions(samples)} for samples in objects]
    return json.dumps(answer)


def _raise_late(_signal: int, _frame: Any) -> None:
    raise TimeoutError("the detector used up its time (time_limit)")


class _InWorker:
    """Calls the function in the process of the trial, with limits on time and memory."""

    def __init__(self, detect: Detect, time_limit: float, memory_mb: int) -> None:
        self._detect, self._time_limit, self._memory_mb = detect, time_limit, memory_mb

    def __call__(self, core: dict[str, Any]) -> str:
        if "torch" in sys.modules:  # its pool of threads does not come along into a forked process
            sys.modules["torch"].set_num_threads(1)
        old = resource.getrlimit(resource.RLIMIT_AS)
        if self._memory_mb:
            with open("/proc/self/statm") as file:
                used = int(file.read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (used + self._memory_mb * _MEGA, old[1]))
        signal.signal(signal.SIGALRM, _raise_late)
        signal.setitimer(signal.ITIMER_REAL, self._time_limit)
        try:
            return _answer(self._detect(Scan._from(core)))
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            resource.setrlimit(resource.RLIMIT_AS, old)


def _receive(connection: socket.socket, count: int) -> bytes:
    parts = []
    while count > 0:
        part = connection.recv(min(count, _MEGA))
        if not part:
            raise ConnectionError("the other side has ended")
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def _send(connection: socket.socket, data: bytes) -> None:
    connection.sendall(struct.pack("<Q", len(data)) + data)


def _message(connection: socket.socket) -> bytes:
    return _receive(connection, struct.unpack("<Q", _receive(connection, 8))[0])


class _InParent:
    """Asks the process that evaluates, where a model stays on a graphics card and scans of several trials form a batch."""

    def __init__(self, path: str, time_limit: float) -> None:
        self._path, self._time_limit = path, time_limit

    def __call__(self, core: dict[str, Any]) -> str:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(self._time_limit)
            connection.connect(self._path)
            _send(connection, pickle.dumps(core))
            try:
                kind, text = pickle.loads(_message(connection))
            except TimeoutError:
                raise TimeoutError("the detector used up its time (time_limit)") from None
        if kind == "error":
            raise RuntimeError(text)
        return str(text)


@contextlib.contextmanager
def _serve(detect_batch: DetectBatch, batch: int, time_limit: float) -> Iterator[_InParent]:
    """Answers trials from a thread of this process, up to `batch` scans at once."""
    def answer(connections: list[socket.socket]) -> None:
        asked = []
        for connection in connections:
            with contextlib.suppress(OSError):  # a trial that was killed
                asked.append((connection, Scan._from(pickle.loads(_message(connection)))))
        if not asked:
            return
        try:
            answers = list(detect_batch([scan for _, scan in asked]))
            if len(answers) != len(asked):
                raise ValueError(f"the detector answered {len(answers)} of {len(asked)} scans")
            replies = [_reply(one) for one in answers]
        except Exception:  # the detector's, whatever it is: an outcome of its trials
            replies = [("error", traceback.format_exc())] * len(asked)
        for (connection, _), reply in zip(asked, replies):
            with contextlib.suppress(OSError):
                _send(connection, pickle.dumps(reply))

    def serve(listener: socket.socket, selector: selectors.BaseSelector, stopped: socket.socket) -> None:
        with listener, selector, stopped:  # closed here, since the detector may be busy for longer than the run
            while True:
                ready = [key.fileobj for key, _ in selector.select()]
                if stopped in ready:
                    return
                connections: list[socket.socket] = []
                listener.setblocking(False)
                with contextlib.suppress(BlockingIOError):
                    while len(connections) < batch:
                        connections.append(listener.accept()[0])
                for connection in connections:
                    connection.settimeout(10.0)
                answer(connections)
                for connection in connections:
                    connection.close()

    folder = tempfile.mkdtemp(prefix="rangegrasp-")  # readable by its owner alone
    with contextlib.ExitStack() as ends, contextlib.ExitStack() as heard:
        ends.callback(shutil.rmtree, folder, ignore_errors=True)
        listener = heard.enter_context(socket.socket(socket.AF_UNIX))
        listener.bind(f"{folder}/ask")
        listener.listen(128)
        stopped, stop = (one.enter_context(end) for one, end in zip((heard, ends), socket.socketpair()))
        selector = heard.enter_context(selectors.DefaultSelector())
        selector.register(listener, selectors.EVENT_READ)
        selector.register(stopped, selectors.EVENT_READ)
        thread = threading.Thread(target=serve, args=(listener, selector, stopped), daemon=True, name="rangegrasp detector")
        thread.start()
        heard.pop_all()
        try:
            yield _InParent(f"{folder}/ask", time_limit)
        finally:
            with contextlib.suppress(OSError):  # the thread has failed
                stop.send(b"x")
            thread.join(timeout=1.0)


def _reply(found: Any) -> tuple[str, str]:
    try:
        return "answer", _answer(found)
    except Exception:  # of one scan of a batch
        return "error", traceback.format_exc()


def _name_of(detect: Any) -> str:
    """The function and a digest of its source, so that `resume` refuses another one."""
    name = getattr(detect, "__qualname__", type(detect).__qualname__)
    try:
        source = inspect.getsource(detect if inspect.isroutine(detect) or inspect.isclass(detect) else type(detect))
    except (OSError, TypeError):  # typed into a shell
        source = ""
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:12]}"


class _Detector:
    """A function with its limits, and where it is called."""

    def __init__(self, detect: Detect | DetectBatch | None, batch: int | None, time_limit: float, memory_mb: int) -> None:
        self._detect, self._batch, self._time_limit, self._memory_mb = detect, batch, time_limit, memory_mb
        self.name = "" if detect is None else _name_of(detect)

    @contextlib.contextmanager
    def asked(self) -> Iterator[Callable[[dict[str, Any]], str] | None]:
        if self._detect is None:
            yield None
        elif self._batch is None:
            yield _InWorker(self._detect, self._time_limit, self._memory_mb)  # type: ignore[arg-type]
        else:
            with _serve(self._detect, self._batch, self._time_limit) as ask:  # type: ignore[arg-type]
                yield ask


class Results:
    """The results of a run, in a folder that the command line reads, too.

    Attributes
    ----------
    folder : Path
    failed : str
        What failed of the run as a whole, e.g. trials that crashed; empty if nothing did.
    """

    def __init__(self, folder: str | os.PathLike[str], failed: str = "", detector: _Detector | None = None) -> None:
        self.folder = Path(folder)
        self.failed = failed
        self._detector = detector or _Detector(None, None, 0.0, 0)

    def table(self, format: str = "text") -> str:
        """The tables, next to the published ones, as "text", "markdown", "csv" or "json"."""
        return _core.table(str(self.folder), format)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One dict a trial: `id`, `group` (the object), `seed`, `outcome`, `stage`, `detail`, `data`, `seconds`."""
        return _core.records(str(self.folder))

    @property
    def records(self) -> "pandas.DataFrame":
        """The same as a table with one column a value, e.g. "data.log.lift_height_m"."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError(f"records needs pandas: pip install 'rangegrasp[pandas]' ({error}); rows does not") from error
        return pandas.json_normalize(self.rows)

    def compare(self, other: "Results") -> dict[str, float]:
        """This run and another one on the same trials: `pairs`, `both`, `only_first`, `only_second`, `same_outcome` and `p_value`
        (McNemar's exact test of the success rate). InputError for a task without a success, e.g. times."""
        if not isinstance(other, Results):
            raise TypeError(f"other must be Results, e.g. rg.load(folder), not {other!r}")
        return _core.compare(str(self.folder), str(other.folder))

    def report(self, folder: str | os.PathLike[str] | None = None, jobs: int = 1, run_detector: bool = False) -> Path:
        """Writes pages with charts and pictures for a browser, into `folder` or the results' own. Returns the first page.

        It runs trials again for their pictures; InputError for results of a function that were loaded from a folder. A program that the
        results name as their detector is started only with `run_detector`, if you trust them.
        """
        with self._detector.asked() as ask:
            _core.report(str(self.folder), jobs, ask, self._detector.name, run_detector)
        pages = self.folder / "report"
        if folder is not None:
            pages = Path(shutil.copytree(pages, folder, dirs_exist_ok=True))
        return pages / "index.html"

    def __repr__(self) -> str:
        return f"Results({str(self.folder)!r})"

    def __str__(self) -> str:
        return self.table()


def load(folder: str | os.PathLike[str]) -> Results:
    """Results of an earlier run, of this package or of `rangegrasp run`."""
    results = Results(folder)
    results.table()
    return results


def _progress(show: bool) -> Callable[[int, int, str], None]:
    if not show:
        return lambda done, total, outcome: None
    from tqdm.auto import tqdm
    bars: list[Any] = []
    counts: dict[str, int] = {}

    def on_trial(done: int, total: int, outcome: str) -> None:
        if not bars:
            bars.append(tqdm(total=total, unit="trial"))
        counts[outcome] = counts.get(outcome, 0) + 1
        bars[0].set_postfix_str(", ".join(f"{word} {n}" for word, n in sorted(counts.items(), key=lambda item: -item[1])[:3]))
        bars[0].update(done - bars[0].n)
        if done == total:
            bars.pop().close()
    return on_trial


def evaluate(detect: Detect | DetectBatch | None = None, experiment: str | os.PathLike[str] = "pile", *, trials: int | None = None,
             objects: str | Sequence[str] = (), seed: int | Sequence[int] | None = None, jobs: int | None = None,
             out: str | os.PathLike[str] | None = None, resume: bool = False, overwrite: bool = False, set: str | Sequence[str] = (),
             batch: int | None = None, time_limit: float = 20.0, memory_mb: int = 4096, progress: bool | None = None) -> Results:
    """Runs an experiment with a detector of your own, and scores it like the built-in one.

    The trials are those of `rangegrasp run` with the same experiment and seed: the same scenes and scans, the same planner, hand and
    judge. What the function does wrong (an exception, a wrong shape, NaN, too much time or memory) fails its trial alone, with the
    reason in the record.

    Parameters
    ----------
    detect : function of a Scan, or None
        Returns a list of `Grasp`, or a `Detection` with objects. None: the built-in method. It is called in a process forked from this
        one for each trial, so a model that is loaded here is there; what it changes is lost.
    experiment : str or path
        An arrangement ("pile"), the name of an experiment, or a file.
    trials : int, optional
        Of each object, instead of the experiment's.
    objects : str or sequence of str
        Only these objects; all if empty.
    seed : int or sequence of int, optional
        Instead of the experiment's; several are pooled.
    jobs : int, optional
        Trials at the same time; the number of cores if not given. Results do not depend on it.
    out : path, optional
        Results folder; a new temporary one if not given.
    resume, overwrite : bool
        Go on with results in `out`, or throw them away; not both.
    set : str or sequence of str
        Keys of the experiment to change, "key.inner=value".
    batch : int, optional
        If given, `detect` is a function of a list of up to so many Scans, which returns one answer for each. It is called in this
        process, from another thread: for models on a graphics card.
    time_limit : float [s]
        Of one call.
    memory_mb : int
        What a call may allocate; 0: no limit. Not with `batch`.
    progress : bool, optional
        Whether to show a progress bar; where stderr is a terminal or a notebook if not given.

    Returns
    -------
    Results

    Raises
    ------
    TypeError
        For a detector that is no function.
    InputError
        For a wrong experiment or key, or results in `out` that are neither to be resumed nor overwritten.
    KeyboardInterrupt
        After Ctrl-C. No process is left; `out` keeps what was done, for `resume`.
    """
    if detect is not None and not callable(detect):
        raise TypeError(f"detect must be a function of a Scan, or None, not {detect!r}; the experiment is the second argument")
    seeds = [] if seed is None else [seed] if isinstance(seed, int) else list(seed)
    settings = words_of(set)
    show = progress if progress is not None else sys.stderr.isatty() or "ipykernel" in sys.modules
    detector = _Detector(detect, batch, time_limit, memory_mb)
    folder = Path(out) if out is not None else Path(tempfile.mkdtemp(prefix="rangegrasp-"))
    try:
        with detector.asked() as ask:
            if ask is not None:
                settings.append("detector=python")
            failed = _core.run(experiment_file(experiment), settings, trials, words_of(objects), seeds, str(folder),
                               jobs or os.cpu_count() or 1, resume, overwrite, ask, detector.name, _progress(show))
    except BaseException:
        if out is None:
            with contextlib.suppress(OSError):  # unless it was refused, it holds what was done
                folder.rmdir()
        raise
    if failed:
        logging.getLogger("rangegrasp").warning("%s", failed)
    return Results(folder, failed, detector)

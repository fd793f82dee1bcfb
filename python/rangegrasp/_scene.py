"""A simulated scene to look at and to grasp in, and perception of any cloud."""
from __future__ import annotations

import difflib
import os
import warnings
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._types import Floats, Found, Grasp, Outcome, Scan, View, _matrix4, _positions


def experiment_file(name: str | os.PathLike[str]) -> str:
    """The experiment of a word for an arrangement ("pile" is laser_pile), a name, or a file."""
    text = os.fspath(name)
    known = _core.experiments()
    if f"laser_{text}" in known:
        return f"laser_{text}"
    near = difflib.get_close_matches(text, [*(one.removeprefix("laser_") for one in known), *known], 1)
    if text not in known and near and not Path(text).exists():
        raise _core.InputError(f"{text}: no such arrangement, experiment or file; nearest: '{near[0]}'")
    return text


def words_of(words: str | Sequence[str]) -> list[str]:
    """A single word stands for a list of one; as a sequence it would be its letters."""
    return [words] if isinstance(words, str) else list(words)


class Scene:
    """A settled scene: table, arm, hand, sensor and objects.

    Parameters
    ----------
    experiment : str or path
        An arrangement ("single", "touching", "side_by_side", "box", "pile"), the name of an experiment (`rg.experiments()`), or a file.
        It says which scene, sensor and objects there are.
    seed : int
        Of the experiment. The same seed, target and index give the trial that `rangegrasp run --seed` runs.
    target : str, optional
        The object of the trial; the experiment's first one if not given.
    index : int
        Which trial of that object, from 0.
    objects : mapping of str to (4, 4) array, or sequence of (str, (4, 4) array), optional
        In place of a drawn arrangement: these objects, at these poses in W, from which they settle.
    set : str or sequence of str
        Keys of the experiment to change, "key.inner=value" (docs/experiment-file.md).

    Raises
    ------
    InputError
        For an unknown experiment, key or object.
    RunError
        If no arrangement comes to rest in the sensor's view.

    Warns
    -----
    UserWarning
        If `objects` overlap at their poses, have moved sideways while they settled, or lie outside the workspace.
    """

    def __init__(self, experiment: str | os.PathLike[str] = "single", seed: int = 1, *, target: str | None = None, index: int = 0,
                 objects: Mapping[str, Any] | Sequence[tuple[str, Any]] | None = None, set: str | Sequence[str] = ()) -> None:
        file = experiment_file(experiment)
        if objects is None:
            self._core = _core.Scene(file, words_of(set), seed, target or "", index)
            return
        if target is not None or index != 0:
            raise ValueError("target and index belong to a drawn arrangement, not to objects")
        pairs = list(objects.items() if isinstance(objects, Mapping) else objects)
        if any(isinstance(pair, str) or len(pair) != 2 for pair in pairs):
            raise ValueError('objects must give each object a pose, {"coffee_cup": X_WO} with X_WO a 4 x 4 matrix')
        poses = [(name, _matrix4(pose, f"the pose of {name}")) for name, pose in pairs]
        self._core = _core.Scene(file, words_of(set), seed, poses)
        for text in self._core.warnings:
            warnings.warn(text, stacklevel=2)

    @property
    def seed(self) -> int:
        """Seed of the trial, from which scans and grasps draw if they are given none."""
        return self._core.seed

    def scan(self, seed: int | None = None) -> Scan:
        """Looks at the scene. The arm goes home first.

        Parameters
        ----------
        seed : int, optional
            Of the sensor's noise; that of the trial if not given.

        Returns
        -------
        Scan
            Its arrays are those of the simulation, not copies.
        """
        return Scan._from(self._core.scan(self.seed if seed is None else seed))

    def perceive(self, seed: int | None = None, *, features: bool = False) -> Found:
        """What a trial's built-in method finds in the last scan: grasps are those of the topmost object.

        Parameters
        ----------
        seed : int, optional
            Of the method's random draws; that of the trial if not given.
        features : bool
            Whether to describe each grasp by numbers, for a score of your own: how free and how well seen the ways of thumb and fingers
            are, how the object's sides end, how near its neighbors are, ... All from the scan.
        """
        return Found._from(self._core.perceive(self.seed if seed is None else seed, features))

    def grasp(self, grasp: Grasp, seed: int | None = None) -> Outcome:
        """Plans and executes one grasp, and judges it. Contact forces alone act between hand and object.

        A grasp that `Scene.perceive` found in the last scan is executed as a trial does. Any other one is first checked for collisions
        with what the last scan shows. The scene is then as the attempt left it.

        A trial goes on to the next grasp if the arm has no motion for one:

            for grasp in found.grasps:
                outcome = scene.grasp(grasp)
                if outcome.word != "no_path":
                    break

        Parameters
        ----------
        grasp : Grasp
        seed : int, optional
            Of planning and of the hand's sensors; that of the trial if not given.
        """
        if not isinstance(grasp, Grasp):
            raise TypeError(f"grasp must be one Grasp, e.g. scene.perceive().grasps[0], not {type(grasp).__name__}")
        X_WG = _matrix4(grasp.X_WG, "X_WG")
        samples = [] if grasp.samples is None else _positions(grasp.samples)
        return Outcome(*self._core.grasp(X_WG, float(grasp.width), grasp._approach, samples,
                                         self.seed if seed is None else seed))

    def take_away(self) -> list[str]:
        """Removes the objects at the delivery place. Returns their names."""
        return self._core.take_away()

    def save(self) -> Any:
        """The state of the scene and what was seen of it, to go back to with `restore`."""
        return self._core.save()

    def restore(self, state: Any) -> None:
        """Goes back to a state of this scene, with the scan and the grasps that it had then."""
        self._core.restore(state)

    def render(self, camera: str = "overview", width: int = 640, height: int = 480) -> NDArray[np.uint8]:
        """A picture of the scene.

        Parameters
        ----------
        camera : str
            A camera of the scene's model, or a free view "x,y,z,lookx,looky,lookz" [m].

        Returns
        -------
        (height, width, 3) uint8
        """
        return self._core.render(camera, width, height)

    @property
    def truth(self) -> dict[str, Any]:
        """Ground truth, which no detector may see.

        Returns
        -------
        dict
            `objects`: one dict an object that is still there (`name`, `label`, `pose` (4, 4), `center_of_mass` (3,), `delivered`);
            `target`: the trial's object, or None; `labels`: for each view of the last scan the label of each sample, (rows, columns)
            uint32, 0 where no object was met. Empty if something has moved since.
        """
        return self._core.truth()


def perceive(points: Scan | NDArray[Any], X_WV: Any = None, *, crop: Any = None, noise: float | None = None, up: Any = None,
             segmentation: str = "convexity", scene: str | os.PathLike[str] = "", seed: int = 1,
             grasped: int | None = None) -> Found:
    """Finds objects and grasps in any cloud of objects on a table, as `rangegrasp perceive` does.

    Parameters
    ----------
    points : Scan, (rows, columns, 3) or (n, 3) array [m]
        NaN or, in an array, 0,0,0 where nothing was measured. A range image keeps its rows and columns.
    X_WV : (4, 4) array, optional
        Pose of the sensor in the frame of the points; at their origin if not given. Belongs to an array.
    crop : six floats [m], optional
        Use only points between x,y,z and x,y,z, the low and the high corner of a box in the frame of the points, e.g.
        (-0.3, -0.3, -1, 0.3, 0.3, 1): without it a robot and the table's edge are objects.
    noise : float, optional
        Standard deviation of the points [m], where it is known better than it can be measured.
    up : (3,) array, optional
        Direction away from the table, where it is known.
    segmentation : str
        How points above the table become segments: "convexity", "mesh" or "region_growing".
    scene : path, optional
        Scene file (MJCF) whose hand is to grasp; the shipped one if not given.
    seed : int
        Of the random draws.
    grasped : int, optional
        Find grasps of so many objects only, the topmost first; of all if not given.

    Returns
    -------
    Found
        In the frame of the points.

    Raises
    ------
    InputError
        If there are fewer than 100 points, no table, a noise below 0 or above 0.05 m, or no points in `crop`.
    TypeError
        For the name of a file instead of its points.

    Warns
    -----
    UserWarning
        If an array has no X_WV, and of what the program warns of: another unit than metres, no objects, objects that are too large. A
        scan of a scene gives no warnings.
    """
    if isinstance(points, (str, os.PathLike)):
        raise TypeError(f'points: pass an array, e.g. np.load("{os.fspath(points)}"), or a Scan, not the name of a file')
    if isinstance(points, Scan):
        if X_WV is not None:
            raise ValueError("a Scan knows its X_WV")
        scan = points
    else:
        array = np.asarray(points, dtype=np.float64)
        if array.ndim == 2:
            array = array[None]
        scan = Scan([View(array, np.eye(4) if X_WV is None else np.asarray(X_WV, dtype=np.float64))])
    corners = None if crop is None else np.asarray(crop, dtype=np.float64).ravel().tolist()
    upwards: Floats | None = None if up is None else np.ascontiguousarray(up, dtype=np.float64)
    core = _core.perceive(scan._core(), corners, noise, upwards, segmentation, str(Path(scene)) if scene else "", seed,
                          2**31 if grasped is None else grasped, scan is points or X_WV is not None)
    for text in core.pop("warnings"):
        warnings.warn(text, stacklevel=2)
    return Found._from(core)

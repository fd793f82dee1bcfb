"""What is measured, found and done, as plain values."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def _matrix4(value: Any, name: str) -> Floats:
    matrix = np.ascontiguousarray(value, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError(f"{name} must be a 4 x 4 matrix, not of shape {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} must be a 4 x 4 matrix of finite numbers, without NaN or infinity")
    return matrix


def _positions(samples: Any) -> list[int]:
    """A mask would silently become positions 0 and 1."""
    array = np.asarray(samples)
    if array.dtype == np.bool_:
        raise TypeError("objects must be positions of samples, e.g. np.flatnonzero(mask), not a mask of True and False")
    positions: list[int] = array.astype(np.int64).ravel().tolist()
    return positions


@dataclass
class View:
    """What one sensor measured from one place.

    Attributes
    ----------
    points : (rows, columns, 3) float64 [m]
        In W, in the order of the scan; NaN where nothing was measured.
    X_WV : (4, 4) float64
        Pose of the sensor, as calibrated: x right, y down, z forward.
    noise : (rows, columns) float32 [m] or None
        Standard deviation of each point along its ray, by the sensor's own model.
    colors : (rows, columns, 3) uint8 or None
        Where the sensor sees colors.
    """
    points: Floats
    X_WV: Floats
    noise: NDArray[np.float32] | None = None
    colors: NDArray[np.uint8] | None = None

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(rows, columns): whether a point was measured."""
        return np.isfinite(self.points[..., 2])


@dataclass
class Scan:
    """One look at a scene, without ground truth: what perception, and a detector of your own, may know.

    The properties `points`, `mask`, `noise`, `colors` and `X_WV` are those of the first view.

    Attributes
    ----------
    views : list of View
        One, or several where a wrist scanner looks again.
    seed : int
        Below 2**53; a detector that draws from it answers the same again.
    noise_m : float [m]
        Standard deviation of the points, measured on the table; 0 if there is none.
    center : (3,) float64 [m]
        Middle of the workspace in W.
    radius : float [m]
        Points further than this from the middle, in the table's plane, are no objects.
    max_opening : float [m]
        Widest gap of the hand's pads; 0 if no hand is known.
    """
    views: list[View]
    seed: int = 0
    noise_m: float = 0.0
    center: Floats = field(default_factory=lambda: np.zeros(3))
    radius: float = np.inf
    max_opening: float = 0.0

    @property
    def points(self) -> Floats:
        return self.views[0].points

    @property
    def mask(self) -> NDArray[np.bool_]:
        return self.views[0].mask

    @property
    def noise(self) -> NDArray[np.float32] | None:
        return self.views[0].noise

    @property
    def colors(self) -> NDArray[np.uint8] | None:
        return self.views[0].colors

    @property
    def X_WV(self) -> Floats:
        return self.views[0].X_WV

    @property
    def rng(self) -> np.random.Generator:
        """A new generator with the scan's seed."""
        return np.random.default_rng(self.seed)

    @staticmethod
    def _from(core: dict[str, Any]) -> "Scan":
        views = [View(**view) for view in core.pop("views")]
        return Scan(views, **core)

    def _core(self) -> dict[str, Any]:
        def of(view: View) -> dict[str, Any]:
            points = np.ascontiguousarray(view.points, dtype=np.float64)
            if points.ndim != 3 or points.shape[2] != 3:
                raise ValueError(f"points must be rows x columns x 3, not {points.shape}")
            noise = None if view.noise is None else np.ascontiguousarray(view.noise, dtype=np.float32)
            if noise is not None and (noise < 0).any():
                raise ValueError(f"noise must be 0 m or more, or NaN where it is not known, not {noise[noise < 0][0]}")
            return {"points": points,
                    "noise": noise,
                    "colors": None if view.colors is None else np.ascontiguousarray(view.colors, dtype=np.uint8),
                    "X_WV": _matrix4(view.X_WV, "X_WV")}
        center = np.ascontiguousarray(self.center, dtype=np.float64)
        if center.shape != (3,) or not np.isfinite(center).all():
            raise ValueError(f"center must be three finite numbers [m], not {center}")
        if not self.radius > 0:
            raise ValueError(f"radius must be above 0 m, or np.inf where there is no limit, not {self.radius}")
        return {"views": [of(view) for view in self.views], "radius": float(self.radius), "center": center}


@dataclass
class Grasp:
    """A pose of the hand and what it is expected to close on.

    Attributes
    ----------
    X_WG : (4, 4) float64
        Frame G: its origin is midway between the pads when they have closed on `width`; x is the closing direction, from the fingers
        to the thumb; z points out of the hand.
    width : float [m]
        Expected width between the closed pads; the hand opens 20 mm wider before.
    approach : (3,) float64 or None
        Unit vector of the straight approach in W; None: z of G.
    score : float
        Higher is tried earlier. What is perceived is ordered by it: by `probability` or, without one, by rules, whose values are
        comparable within a `type` only.
    opening, object, type, collides, contact_angle, samples
        What `perceive` knows besides: gap of the pads before closing [m], position in `Found.objects`, kind of grasp, the built-in
        collision check's verdict, by how much the gripped faces lean away from facing each other [rad], and the samples of its object.
        Without `samples` the object is what lies between the open fingers.
    probability : float or None
        That it is delivered, as predicted by the learned score; None with `grasp.score: rules` and for grasps of your own.
    """
    X_WG: Floats
    width: float
    approach: Floats | None = None
    score: float = 0.0
    opening: float | None = None
    object: int = 0
    type: str = ""
    collides: bool = False
    contact_angle: float = 0.0
    samples: NDArray[np.int64] | None = field(default=None, repr=False)
    probability: float | None = None

    @property
    def _approach(self) -> Floats:
        of_hand = np.asarray(self.X_WG)[:3, 2]
        return np.ascontiguousarray(of_hand if self.approach is None else self.approach, dtype=np.float64)

    def _json(self) -> dict[str, Any]:
        X = _matrix4(self.X_WG, "X_WG")
        return {"object": int(self.object), "position_m": X[:3, 3].tolist(), "rotation": X[:3, :3].tolist(),
                "width_m": float(self.width), "approach": self._approach.tolist(), "score": float(self.score)}


@dataclass
class Object:
    """A perceived object.

    Attributes
    ----------
    points : (n, 3) float64 [m]
        Its measured points in W.
    samples : (n,) int64
        Their positions in `points.reshape(-1, 3)` of the scan's views, one after the other.
    rotational, open : bool
        Whether it has an axis of rotation; whether it is a container.
    center, size : (3,) float64 [m]
        Of the box around its completed shape, turned like the object: its longer side, shorter side and height.
    """
    points: Floats
    samples: NDArray[np.int64]
    rotational: bool = False
    open: bool = False
    center: Floats = field(default_factory=lambda: np.zeros(3))
    size: Floats = field(default_factory=lambda: np.zeros(3))

    def __repr__(self) -> str:
        return f"Object({len(self.samples)} points, center {np.round(self.center, 3)} m, size {np.round(self.size, 3)} m)"


@dataclass
class Found:
    """What the built-in method finds in a scan.

    Attributes
    ----------
    table_normal : (3,) float64
        Unit, away from the table; a point x of the table has `table_normal @ x + table_offset = 0`.
    table_offset : float [m]
    noise : float [m]
        Standard deviation of the points, measured on the table.
    objects : list of Object
        Topmost first.
    grasps : list of Grasp
        Of the first object first, each object's best first (`score`); those that collide come last within an object.
    features : (grasps, features) float64 or None
        What `Scene.perceive(features=True)` says of each grasp; `feature_names()` names the columns.
    """
    table_normal: Floats
    table_offset: float
    noise: float
    objects: list[Object]
    grasps: list[Grasp]
    features: Floats | None = None

    def __repr__(self) -> str:
        return f"Found({len(self.objects)} objects, {len(self.grasps)} grasps, noise {1e3 * self.noise:.2f} mm)"

    @staticmethod
    def _from(core: dict[str, Any]) -> "Found":
        objects = [Object(**one) for one in core.pop("objects")]
        grasps = [Grasp(**one, samples=objects[one["object"]].samples) for one in core.pop("grasps")]
        return Found(**core, objects=objects, grasps=grasps)


@dataclass
class Detection:
    """What a detector of your own returns where it names objects too.

    Attributes
    ----------
    grasps : sequence of Grasp
        The best 200 of the first object are used.
    objects : sequence of (n,) int arrays, or None
        Samples of each object, as positions in `points.reshape(-1, 3)` of the scan's views, one after the other, like
        `Object.samples`; the first object is taken and scored. None: the object is what lies between the fingers of the best grasp.
    """
    grasps: Sequence[Grasp]
    objects: Sequence[Sequence[int] | NDArray[Any]] | None = None


@dataclass(frozen=True)
class Outcome:
    """How an attempt ended.

    Attributes
    ----------
    word : str
        "delivered", "no_grasp" (the hand collides), "no_path", "not_lifted", "dropped", "misplaced" or "invalid_physics".
    stage : str
        The stage in which it ended.
    detail : str
        One line for a person.
    log : dict
        All that a trial's record holds, with the object that it was at (`target`).
    """
    word: str
    stage: str
    detail: str
    log: dict[str, Any]

    @property
    def delivered(self) -> bool:
        return self.word == "delivered"

"""Gymnasium environments: `gym.make("rangegrasp/Pile-v0")`, and Single, Touching, SideBySide and Box (pip install 'rangegrasp[gym]')."""
from __future__ import annotations

from typing import Any, Sequence, SupportsFloat

import gymnasium
import numpy as np
from numpy.typing import NDArray

from . import _core
from ._scene import Scene, experiment_file, words_of
from ._types import Grasp, Outcome, Scan

Observation = dict[str, NDArray[Any]]

MAX_PROPOSALS = 64
MAX_VALUE = 100.0  # of a proposal's numbers
NEAR_M = 2.0  # coordinates beyond are no part of the work cell


def pose_of(action: NDArray[Any]) -> Grasp:
    """The grasp of an action that is a pose: x, y, z [m], a rotation vector [rad] and the width [m]."""
    vector = np.asarray(action, dtype=float)
    angle = float(np.linalg.norm(vector[3:6]))
    axis = vector[3:6] / angle if angle > 1e-12 else np.array([0.0, 0.0, 1.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    X_WG = np.eye(4)
    X_WG[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    X_WG[:3, 3] = vector[:3]
    return Grasp(X_WG, float(vector[6]))


def action_of(grasp: Grasp) -> NDArray[np.float32]:
    """The action of `pose_of` that stands for a grasp."""
    R = np.asarray(grasp.X_WG)[:3, :3]
    angle = float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1)))
    if angle > np.pi - 1e-6:  # the axis is the eigenvector of 1
        values, vectors = np.linalg.eigh((R + R.T) / 2)
        axis = vectors[:, np.argmax(values)]
    else:
        axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / max(2 * np.sin(angle), 1e-12)
    return np.concatenate([np.asarray(grasp.X_WG)[:3, 3], angle * axis, [grasp.width]]).astype(np.float32)


class GraspEnv(gymnasium.Env[Observation, Any]):
    """One attempt an episode, or attempts until the table is clear.

    Observation: a dict with `points` (rows, columns, 3) float32 [m] in W, 0 where nothing was measured, `mask` (rows, columns) int8, and with
    action="proposal" `proposals` (64, 8) float32: x, y, z, rotation vector, width and score of each candidate of the topmost object, best
    first, 0 where there are fewer. Reward: 1 for a delivered object, else 0. `info` holds the outcome's word.

    Parameters
    ----------
    experiment : str
        As for `Scene`.
    action : "pose" or "proposal"
        A pose of frame G as x, y, z [m], rotation vector [rad], and width [m]; or the position of a candidate.
    until_cleared : bool
        Whether an episode goes on until nothing is left, `max_attempts` are used up, or no candidate is left. What was delivered is taken
        away. Else it is one attempt.
    max_attempts : int
    target : str, optional
        The object that an arrangement is drawn for; drawn among the experiment's if not given.
    set : str or sequence of str
        Keys of the experiment to change.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}

    def __init__(self, experiment: str = "pile", *, action: str = "proposal", until_cleared: bool = False, max_attempts: int = 30,
                 target: str | None = None, set: str | Sequence[str] = (), render_mode: str | None = None) -> None:
        if action not in ("pose", "proposal"):
            raise ValueError(f"action must be 'pose' or 'proposal', not {action!r}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        self.render_mode = render_mode
        self._experiment, self._action, self._set, self._target = experiment, action, words_of(set), target
        self._attempts_left, self._max_attempts = 0, max_attempts if until_cleared else 1
        self._names = _core.objects(experiment_file(experiment), self._set)
        self._scene: Scene | None = None
        self._proposals: list[Grasp] = []
        shape = Scene(experiment, 0, target=target or self._names[0], set=self._set).scan().points.shape
        spaces: dict[str, gymnasium.Space[Any]] = {
            "points": gymnasium.spaces.Box(-NEAR_M, NEAR_M, shape, np.float32),
            "mask": gymnasium.spaces.MultiBinary(shape[:2]),
        }
        if action == "proposal":
            spaces["proposals"] = gymnasium.spaces.Box(-MAX_VALUE, MAX_VALUE, (MAX_PROPOSALS, 8), np.float32)
            self.action_space: gymnasium.Space[Any] = gymnasium.spaces.Discrete(MAX_PROPOSALS)
        else:
            reach = np.array([0.4, 0.4, 0.5, np.pi, np.pi, np.pi, 0.1], np.float32)
            low = -reach
            low[[2, 6]] = 0.0
            self.action_space = gymnasium.spaces.Box(low, reach, dtype=np.float32)
        self.observation_space: gymnasium.Space[Any] = gymnasium.spaces.Dict(spaces)

    def _observe(self) -> Observation:
        assert self._scene is not None
        scan: Scan = self._scene.scan(int(self.np_random.integers(2**53)))
        mask = scan.mask & (np.abs(np.nan_to_num(scan.points)) < NEAR_M).all(axis=-1)
        seen: Observation = {"points": np.where(mask[..., None], scan.points, 0.0).astype(np.float32), "mask": mask.astype(np.int8)}
        if self._action == "proposal":
            found = self._scene.perceive(int(self.np_random.integers(2**53)))
            self._proposals = [grasp for grasp in found.grasps if not grasp.collides][:MAX_PROPOSALS]
            seen["proposals"] = np.zeros((MAX_PROPOSALS, 8), np.float32)
            for i, grasp in enumerate(self._proposals):
                seen["proposals"][i] = np.clip([*action_of(grasp), grasp.score], -MAX_VALUE, MAX_VALUE)
        return seen

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._attempts_left = self._max_attempts
        for _ in range(100):
            target = self._target or str(self.np_random.choice(self._names))
            try:
                self._scene = Scene(self._experiment, int(self.np_random.integers(2**53)), target=target, set=self._set)
                break
            except _core.RunError:  # no arrangement came to rest in view: another one
                continue
        else:
            raise _core.RunError("100 arrangements in a row did not come to rest in view")
        return self._observe(), {"proposals": len(self._proposals)}

    def _attempt(self, action: Any) -> Outcome:
        assert self._scene is not None
        if self._action == "pose":
            return self._scene.grasp(pose_of(action), int(self.np_random.integers(2**53)))
        number = int(action)
        if number >= len(self._proposals):
            return Outcome("no_grasp", "grasp", f"there are {len(self._proposals)} proposals", {})
        return self._scene.grasp(self._proposals[number], int(self.np_random.integers(2**53)))

    def step(self, action: Any) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        if self._scene is None or self._attempts_left <= 0:
            raise RuntimeError("call reset before step")
        outcome = self._attempt(action)
        self._attempts_left -= 1
        self._scene.take_away()
        observation = self._observe()
        left = len(self._scene.truth["objects"])
        done = self._max_attempts == 1 or left == 0 or (self._action == "proposal" and not self._proposals)
        truncated = not done and self._attempts_left <= 0
        if done or truncated:
            self._attempts_left = 0
        info = {"outcome": outcome.word, "detail": outcome.detail, "left": left, "proposals": len(self._proposals)}
        return observation, float(outcome.delivered), done, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        if self.render_mode is None or self._scene is None:
            return None
        return self._scene.render()

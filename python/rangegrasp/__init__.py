"""rangegrasp: a physics-simulated testbed for grasping unknown objects from range images.

    import rangegrasp as rg

    scene = rg.Scene("pile", seed=7)
    scan = scene.scan()
    found = rg.perceive(scan)
    outcome = scene.grasp(found.grasps[0])

All lengths are metres, all angles radians. `X_AB` is the pose of frame B in frame A as a 4 x 4 matrix. W is the world: its origin is
on the table top at the middle of the workspace, z up, x from the arm to the scanner. The computation is C++; the page docs/python.md
has examples.
"""
from ._core import InputError, RunError, data_folder, experiments, feature_names
from ._core import version as _version
from ._collect import collect
from ._evaluate import Results, evaluate, load
from ._types import Detection, Found, Grasp, Object, Outcome, Scan, View
from ._scene import Scene, perceive

__version__ = _version()

__all__ = [
    "Detection", "Found", "Grasp", "InputError", "Object", "Outcome", "Results", "RunError", "Scan", "Scene", "View",
    "collect", "data_folder", "evaluate", "experiments", "feature_names", "load", "perceive",
]


def _register_environments() -> None:
    try:
        import gymnasium
    except ImportError:  # an extra: pip install 'rangegrasp[gym]'
        return
    for word in ("single", "touching", "side_by_side", "box", "pile"):
        name = "".join(part.capitalize() for part in word.split("_"))
        gymnasium.register(id=f"rangegrasp/{name}-v0", entry_point="rangegrasp.gym:GraspEnv",
                           kwargs={"experiment": word})


_register_environments()

"""The environments keep Gymnasium's contract."""
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

import rangegrasp as rg  # noqa: E402
from rangegrasp.gym import action_of, pose_of  # noqa: E402


@pytest.mark.parametrize("arguments", [{}, {"action": "pose"}, {"until_cleared": True, "max_attempts": 2}])
def test_an_environment_passes_the_checker(arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(gymnasium.make("rangegrasp/Single-v0", **arguments).unwrapped, skip_render_check=True)


def test_actions_are_poses_and_back():
    for grasp in rg.Scene("single", seed=42).perceive().grasps:
        again = pose_of(action_of(grasp))
        assert np.allclose(again.X_WG, grasp.X_WG, atol=1e-5) and abs(again.width - grasp.width) < 1e-6
    half_turn = rg.Grasp(np.diag([1.0, -1.0, -1.0, 1.0]), 0.05)
    assert np.allclose(pose_of(action_of(half_turn)).X_WG, half_turn.X_WG, atol=1e-6)


def test_the_best_proposal_of_a_lone_object_is_rewarded():
    env = gymnasium.make("rangegrasp/Single-v0", target="salt_cylinder")
    seen, info = env.reset(seed=42)
    assert info["proposals"] > 0 and (seen["proposals"][0] != 0).any()
    _, reward, terminated, truncated, info = env.step(0)
    assert (reward, terminated, truncated, info["outcome"]) == (1.0, True, False, "delivered")


def test_the_same_seed_is_the_same_episode():
    def episode():
        env = gymnasium.make("rangegrasp/Touching-v0", until_cleared=True, max_attempts=3)
        seen, _ = env.reset(seed=7)
        told = [seen["points"].sum()]
        for _ in range(3):
            seen, reward, terminated, truncated, info = env.step(0)
            told += [reward, info["outcome"], seen["points"].sum()]
            if terminated or truncated:
                break
        return told
    assert episode() == episode()


def test_it_vectorises_over_processes():
    envs = gymnasium.make_vec("rangegrasp/Single-v0", num_envs=2, vectorization_mode="async")
    try:
        seen, _ = envs.reset(seed=[1, 2])
        assert seen["points"].shape[0] == 2
        _, rewards, _, _, _ = envs.step(np.array([0, 0]))
        assert rewards.shape == (2,)
    finally:
        envs.close()


def test_a_number_without_a_proposal_is_no_grasp():
    env = gymnasium.make("rangegrasp/Single-v0", target="sweets_half_cylinder")
    _, info = env.reset(seed=43)
    assert 0 < info["proposals"] < 64
    _, reward, terminated, _, info = env.step(63)
    assert reward == 0.0 and terminated and info["outcome"] == "no_grasp"


def test_wrong_arguments_are_refused():
    with pytest.raises(ValueError, match="proposal"):
        gymnasium.make("rangegrasp/Single-v0", action="word")
    with pytest.raises(RuntimeError, match="reset"):
        gymnasium.make("rangegrasp/Single-v0").unwrapped.step(0)

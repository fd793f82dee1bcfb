"""Three policies that clear a table: random proposals, the best proposal, and a score learnt from its own attempts (docs/python.md).

Arguments: the number of training episodes (half as many are used for the test) and the maximum number of attempts per episode."""
import sys
from typing import Any, Callable, Iterable

import gymnasium
import numpy as np
import rangegrasp  # noqa: F401  registers the environments
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def features(seen: dict[str, Any], tried: Floats) -> Floats:
    """(proposals, 6): height, tilt, width, the method's score, its rank, and whether it was tried in this episode."""
    proposals = seen["proposals"]
    rank = np.arange(len(proposals)) / len(proposals)
    turn = np.linalg.norm(proposals[:, 3:6], axis=1)
    return np.stack([10 * proposals[:, 2], turn - np.pi, 20 * proposals[:, 6], proposals[:, 7], rank, tried], axis=1)


def run(env: gymnasium.Env[Any, Any], choose: Callable[[Floats], int], seeds: Iterable[int],
        learn: Callable[[Floats, float], None] | None = None) -> tuple[float, int]:
    delivered, attempts = 0.0, 0
    for seed in seeds:
        seen, info = env.reset(seed=seed)
        tried, done = np.zeros(len(seen["proposals"])), info["proposals"] == 0
        while not done:
            known = features(seen, tried)[:info["proposals"]]
            action = choose(known)
            tried[action] = 1.0
            seen, reward, ended, truncated, info = env.step(action)
            done, attempts, delivered = ended or truncated, attempts + 1, delivered + float(reward)
            if reward or info["outcome"] not in ("no_path", "no_grasp"):  # the scene has changed
                tried[:] = 0.0
            if learn:
                learn(known[action], float(reward))
    return delivered, attempts


class Learnt:
    """Logistic regression by stochastic gradient ascent; 10 % of its choices are random."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.weights, self.rng = np.zeros(7), rng

    def probability(self, known: Floats) -> Floats:
        return np.asarray(1 / (1 + np.exp(-(np.atleast_2d(known) @ self.weights[:-1] + self.weights[-1]))), dtype=np.float64)

    def choose(self, known: Floats) -> int:
        return int(self.rng.integers(len(known))) if self.rng.random() < 0.1 else int(np.argmax(self.probability(known)))

    def learn(self, known: Floats, reward: float) -> None:
        self.weights += 0.3 * (reward - self.probability(known)[0]) * np.append(known, 1.0)


if __name__ == "__main__":
    episodes = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    most = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    env = gymnasium.make("rangegrasp/Pile-v0", until_cleared=True, max_attempts=most)
    rng, learnt = np.random.default_rng(0), Learnt(np.random.default_rng(1))
    run(env, learnt.choose, range(100, 100 + episodes), learnt.learn)
    test = range(500, 500 + episodes // 2)
    for name, choose in (("random", lambda known: int(rng.integers(len(known)))), ("best proposal not yet tried", lambda known: int(
            np.argmax(-known[:, 4] - 10 * known[:, 5]))), ("learnt", learnt.choose)):
        delivered, attempts = run(env, choose, test)
        print(f"{name}: {delivered:.0f} objects delivered in {attempts} attempts of {len(test)} episodes")

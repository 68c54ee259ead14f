"""Any environment of Gymnasium with a policy as a system under test: `gymnasium_rig.py --env ID --policy POLICY [...]`.

POLICY is `random`, `MODULE:NAME` (a file beside the study's ledger, or a module of Python's path) or `lerobot:FOLDER`. NAME
is a function of the observation that gives the action; or a class, made for each episode with the environment, that has
`select_action(observation)` and, if it draws or remembers anything, `reset(seed)`.

Settings of the stimulus: `env.KEY` goes to `gymnasium.make`, `reset.KEY` to the options of `reset`. Everything random has the seed
of the episode: the environment, its spaces, the policy. Recorded, row by row: the observation, the action that led to it, its reward
and the sum of rewards, `terminated` and `truncated`. Times are steps of `--step-secs`, else of what the environment says.
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import gymnasium
import numpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "common"), str(HERE)]

from corroborate_rig import Episode, Recording, main  # noqa: E402

# At the beginning there is no reward yet, so rewards are a topic of their own, without a row there.
OUTCOME = ("/reward.value", "/reward.total", "/end.terminated", "/end.truncated")


class RandomPolicy:
    """Whatever the space of actions offers."""

    def __init__(self, env: gymnasium.Env):
        self.space = env.action_space

    def reset(self, seed: int) -> None:
        """From here on the same actions for the same seed."""
        self.space.seed(seed)

    def select_action(self, observation: Any) -> Any:
        """Any action."""
        return self.space.sample()


def loaded(name: str) -> Callable[[gymnasium.Env], Any]:
    """What makes a policy for an environment."""
    kind, _, rest = name.partition(":")
    if name == "random":
        return RandomPolicy
    if kind == "lerobot" and rest:
        return lambda env: importlib.import_module("lerobot_policy").LeRobotPolicy(rest)
    if not rest:
        sys.exit(f"`{name}` is no policy; write `random`, `MODULE:NAME` or `lerobot:FOLDER`")
    if kind.endswith(".py"):
        sys.path.insert(0, str(Path(kind).resolve().parent))
        kind = Path(kind).stem
    found = getattr(importlib.import_module(kind), rest)
    return found if isinstance(found, type) else lambda env: found


def leaves(name: str, space: gymnasium.Space, value: Any = None) -> Iterator[Tuple[str, Any]]:
    """The numbers of a value of a space, each with a name; arrays of more than one dimension (pictures) are left out."""
    if isinstance(space, gymnasium.spaces.Dict):
        for key, inner in space.spaces.items():
            yield from leaves(f"{name}_{key}" if name else key, inner, None if value is None else value[key])
    elif isinstance(space, gymnasium.spaces.Discrete):
        yield name or "value", None if value is None else float(value)
    elif space.shape is not None and len(space.shape) <= 1:
        count = math.prod(space.shape)
        flat: Sequence[Any] = [None] * count if value is None else numpy.ravel(value).tolist()
        for index, number in enumerate(flat):
            yield f"{name or 'value'}_{index}", number


def signals(topic: str, space: gymnasium.Space, names: str) -> List[str]:
    """The signals of a space; `names`, separated by commas, in place of those that it has without."""
    own = [name for name, _ in leaves("", space)]
    given = names.split(",") if names else own
    if len(given) != len(own):
        raise ValueError(f"{topic[1:]} has {len(own)} numbers ({', '.join(own)}), but {len(given)} names: {names}")
    return [f"{topic}.{name}" for name in given]


def settings_of(episode: Episode, prefix: str) -> Dict[str, Any]:
    """Settings under a prefix, without it."""
    return {key[len(prefix) :]: value for key, value in episode.settings.items() if key.startswith(prefix)}


def step_secs_of(env: gymnasium.Env, given: Optional[float]) -> float:
    """How long a step is: as given, or as the environment has it under the names that are in use."""
    own = env.unwrapped
    found = given or getattr(own, "dt", None) or getattr(own, "tau", None)
    if found is None and env.metadata.get("render_fps"):
        found = 1.0 / env.metadata["render_fps"]
    if found is None:
        sys.exit("the environment does not say how long a step is; give `--step-secs`")
    return float(found)


def runner(
    env_id: str, policy: str, step_secs: Optional[float] = None, names: Tuple[str, str] = ("", "")
) -> Callable[[Episode], Recording]:
    """What runs an episode: a new environment and a new policy for each, so that none remembers another."""
    make_policy = loaded(policy)

    def run(episode: Episode) -> Recording:
        env = gymnasium.make(env_id, **settings_of(episode, "env."))
        try:
            return played(env, make_policy(env), episode, step_secs_of(env, step_secs), names)
        finally:
            env.close()

    return run


def played(
    env: gymnasium.Env, policy: Any, episode: Episode, step_secs: float, names: Tuple[str, str] = ("", "")
) -> Recording:
    """One episode, until it is over."""
    seed = episode.seed % 2**31
    seen, _ = env.reset(seed=seed, options=settings_of(episode, "reset.") or None)
    if hasattr(policy, "reset"):
        policy.reset(seed)
    act = getattr(policy, "select_action", policy)
    spaces = (env.observation_space, env.action_space)
    recorded = signals("/observation", spaces[0], names[0]) + signals("/action", spaces[1], names[1])
    recording = Recording({name: "" for name in (*recorded, *OUTCOME)})
    action, reward, total, over, step = None, None, None, (False, False), 0
    while True:
        cells = [cell for space, value in zip(spaces, (seen, action)) for _, cell in leaves("", space, value)]
        recording.row(step * step_secs, *cells, reward, total, *over)
        if any(over):
            return recording
        action = act(seen)
        seen, reward, *over, _ = env.step(action)
        reward, total, step = float(reward), (total or 0.0) + float(reward), step + 1


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A Gymnasium environment with a policy as a rig.")
    parser.add_argument("--env", required=True, help="a registered environment")
    parser.add_argument("--policy", default="random", help="random, MODULE:NAME or lerobot:FOLDER")
    parser.add_argument("--step-secs", type=float, help="how long a step is")
    parser.add_argument("--observation", default="", help="names of its numbers, separated by commas")
    parser.add_argument("--action", default="", help="the same of actions")
    parser.add_argument("episode", nargs="*", help="STIMULUS SEED RECORDING; nothing with `persistent = true`")
    asked = parser.parse_args()
    # Policies that are files are looked for where the command runs: in the study's folder.
    sys.path.insert(0, "")
    names = (asked.observation, asked.action)
    main(runner(asked.env, asked.policy, asked.step_secs, names), asked.episode)

import sys
import tempfile
import unittest
from pathlib import Path

import gymnasium
import numpy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import gymnasium_rig  # noqa: E402
from corroborate_rig import Episode  # noqa: E402


def episode(seed: int, **settings: float) -> Episode:
    return Episode(seed, "t", (), {key.replace("__", "."): value for key, value in settings.items()})


def rows(recording) -> list:
    return [row.split(",") for row in recording.rows]


class Remembers:
    """A policy that would act otherwise if it were not made anew for each episode."""

    def __init__(self, env: gymnasium.Env):
        self.count = 0

    def reset(self, seed: int) -> None:
        self.first = seed % 2

    def select_action(self, observation) -> int:
        self.count += 1
        return (self.first + self.count // 3) % 2


class TestGymnasium(unittest.TestCase):
    def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(self) -> None:
        for env in ("CartPole-v1", "Pendulum-v1"):
            run = gymnasium_rig.runner(env, "random")
            first = run(episode(7)).text()
            other = run(episode(8)).text()
            self.assertEqual(run(episode(7)).text(), first)
            self.assertNotEqual(other, first)

    def test_what_the_environment_says_is_recorded(self) -> None:
        recording = gymnasium_rig.runner("CartPole-v1", "random", names=("x,v,angle,rate", "push"))(episode(3))
        self.assertEqual(
            recording.header,
            ["time_secs", "/observation.x", "/observation.v", "/observation.angle", "/observation.rate", "/action.push",
             "/reward.value", "/reward.total", "/end.terminated", "/end.truncated"],
        )
        told = rows(recording)
        env = gymnasium.make("CartPole-v1")
        seen, _ = env.reset(seed=3)
        self.assertEqual(told[0], ["0.0", *map(repr, seen.tolist()), "", "", "", "false", "false"])
        for number, row in enumerate(told[1:], 1):
            seen, reward, terminated, *_ = env.step(int(float(row[5])))
            self.assertAlmostEqual(float(row[0]), 0.02 * number)
            self.assertEqual(row[1:5], list(map(repr, seen.tolist())))
            self.assertEqual(row[6:], [repr(float(reward)), repr(float(number)), str(terminated).lower(), "false"])
        self.assertEqual(told[-1][8], "true")

    def test_settings_reach_the_environment(self) -> None:
        run = gymnasium_rig.runner("Pendulum-v1", "random")
        start = rows(run(episode(5, reset__x_init=0.01, reset__y_init=0.01)))[0]
        self.assertGreater(float(start[1]), 0.999)
        self.assertNotEqual(run(episode(5, env__g=3.0)).text(), run(episode(5)).text())
        self.assertEqual(len(rows(run(episode(5)))), 201)

    def test_policies_are_functions_or_made_for_each_episode(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "left_policy.py"
            path.write_text("def left(observation):\n    return 0\n", encoding="utf-8")
            pushes = {row[5] for row in rows(gymnasium_rig.runner("CartPole-v1", f"{path}:left")(episode(1)))}
        self.assertEqual(pushes, {"", "0.0"})
        run = gymnasium_rig.runner("CartPole-v1", f"{__name__}:Remembers")
        first = run(episode(4)).text()
        run(episode(5))
        self.assertEqual(run(episode(4)).text(), first)

    def test_nested_observations_have_names_and_pictures_are_left_out(self) -> None:
        spaces = gymnasium.spaces
        arm = spaces.Dict({"angle": spaces.Box(-1, 1, (2,)), "mode": spaces.Discrete(3)})
        space = spaces.Dict({"arm": arm, "camera": spaces.Box(0, 255, (4, 4, 3), numpy.uint8)})
        value = {"arm": {"angle": numpy.array([0.5, 0.25]), "mode": 2}, "camera": numpy.zeros((4, 4, 3))}
        self.assertEqual(
            list(gymnasium_rig.leaves("", space, value)), [("arm_angle_0", 0.5), ("arm_angle_1", 0.25), ("arm_mode", 2.0)]
        )
        self.assertEqual([cell for _, cell in gymnasium_rig.leaves("", space)], [None] * 3)

    def test_mistakes_are_named(self) -> None:
        with self.assertRaisesRegex(ValueError, "has 4 numbers .* but 2 names"):
            gymnasium_rig.runner("CartPole-v1", "random", names=("x,v", ""))(episode(1))
        with self.assertRaises(gymnasium.error.NameNotFound):
            gymnasium_rig.runner("Trolley-v0", "random")(episode(1))
        with self.assertRaisesRegex(SystemExit, "no policy"):
            gymnasium_rig.runner("CartPole-v1", "best")


if __name__ == "__main__":
    unittest.main()

import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "common")]

import isaac_world  # noqa: E402
import stand_in  # noqa: E402
from corroborate_rig import Recording  # noqa: E402
from isaac_world import World  # noqa: E402

TIME_STEP_SECS = 0.01


class TestIsaac(unittest.TestCase):
    def setUp(self) -> None:
        isaac_world._APP = None
        self.addCleanup(stand_in.install())
        room = tempfile.TemporaryDirectory()
        self.addCleanup(room.cleanup)
        self.usd = Path(room.name) / "slider.usd"
        self.usd.write_text("#usda 1.0\n", encoding="utf-8")

    def world(self) -> World:
        world = World(TIME_STEP_SECS)
        world.add("slider", self.usd, (1.0, 2.0, 0.5), root="/rail")
        world.reset()
        return world

    def pushed(self, world: World) -> str:
        recording = Recording({"/slide.x": "m", "/slide.v": "m/s"})
        world.reset()
        for step in range(100):
            world.push("slider", "slide", 3.0 if step < 50 else 0.0)
            world.step()
            recording.row((step + 1) * TIME_STEP_SECS, *world.joint("slider", "slide"))
        return recording.text()

    def test_a_carriage_that_is_pushed_obeys_newton(self) -> None:
        rows = [list(map(float, line.split(","))) for line in self.pushed(self.world()).splitlines()[1:]]
        # An effort holds until another is given, although the engine forgets it after a step.
        self.assertAlmostEqual(rows[49][2], 3.0 / 2.0 * 0.5, delta=1e-6)
        self.assertAlmostEqual(rows[49][1], 1.5 * TIME_STEP_SECS**2 * 50 * 51 / 2, delta=1e-6)
        self.assertAlmostEqual(rows[99][1] - rows[49][1], 0.75 * 0.5, delta=1e-5)
        self.assertAlmostEqual(rows[99][2], 0.75, delta=1e-6)

    def test_the_same_again_is_the_same_to_the_last_bit(self) -> None:
        world = self.world()
        first = self.pushed(world)
        self.assertEqual(self.pushed(world), first)
        world.close()
        self.assertEqual(self.pushed(self.world()), first)

    def test_efforts_end_with_the_episode(self) -> None:
        world = self.world()
        world.push("slider", "slide", 3.0)
        world.step()
        world.reset()
        world.step()
        self.assertEqual(world.joint("slider", "slide"), (0.0, 0.0))

    def test_poses_are_of_the_world_with_w_last(self) -> None:
        world = self.world()
        world.push("slider", "slide", 200.0)
        world.step()
        self.assertAlmostEqual(world.position("slider")[0], 1.0 + 0.01, delta=1e-6)
        self.assertEqual(world.position("slider")[1:], (2.0, 0.5))
        for number, expected in zip(world.orientation("slider"), (0.0, 0.0, 0.5**0.5, 0.5**0.5)):
            self.assertAlmostEqual(number, expected, delta=1e-6)
        world.add("block", self.usd, (0, 0, 3), articulated=False)
        world.reset()
        self.assertEqual(world.speed("block"), 5.0)
        self.assertEqual(stand_in.Stage.references["/World/block"], str(self.usd))

    def test_things_are_asked_in_the_right_order(self) -> None:
        world = World(TIME_STEP_SECS)
        world.add("slider", self.usd, (0, 0, 0))
        for ask in (lambda: world.joint("slider", "slide"), world.step, lambda: world.push("slider", "slide", 1.0)):
            with self.assertRaisesRegex(RuntimeError, "only after `reset`"):
                ask()
        world.reset()
        world.step()
        world.add("other", self.usd, (1, 0, 0))
        with self.assertRaisesRegex(RuntimeError, "only after `reset`"):
            world.step()

    def test_mistakes_are_named(self) -> None:
        world = self.world()
        with self.assertRaisesRegex(KeyError, "slider has no joint `glide`; it has latch, slide"):
            world.push("slider", "glide", 1.0)
        with self.assertRaisesRegex(KeyError, "no thing called `crate`; there are slider"):
            world.position("crate")
        with self.assertRaisesRegex(FileNotFoundError, "none.usd does not exist"):
            world.add("a", "none.usd", (0, 0, 0))
        with self.assertRaisesRegex(ValueError, "already a thing called `slider`"):
            world.add("slider", self.usd, (0, 0, 0))
        with self.assertRaisesRegex(ValueError, "must be positive .got 0."):
            World(0.0)

    def test_an_application_that_runs_is_taken(self) -> None:
        app = stand_in.SimulationApp({"headless": True})
        self.assertEqual(World(TIME_STEP_SECS, app=app).things, {})
        self.assertIs(isaac_world.application(), app)

    def test_without_isaac_sim_it_says_so(self) -> None:
        sys.modules.pop("isaacsim")
        with self.assertRaisesRegex(RuntimeError, "Isaac Sim cannot be imported .* run this with its own Python"):
            World(TIME_STEP_SECS)


if __name__ == "__main__":
    unittest.main()

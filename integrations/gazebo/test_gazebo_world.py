import os
import stat
import sys
import tempfile
import threading
import types
import unittest
from pathlib import Path
from unittest import mock

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "common")]

import stand_in  # noqa: E402
from corroborate_rig import Recording  # noqa: E402
from gazebo_world import GzTransport, World, served  # noqa: E402
from gz.msgs10.double_pb2 import Double  # noqa: E402


class TestGazebo(unittest.TestCase):
    def setUp(self) -> None:
        module = types.ModuleType("gz.transport13")
        module.Node = stand_in.Node
        patch = mock.patch.dict(sys.modules, {"gz.transport13": module})
        patch.start()
        self.addCleanup(patch.stop)

    def world(self, name: str = "w", step_secs: float = 0.001, limit_secs: float = 5.0, **more) -> World:
        self.server = stand_in.Node.server = stand_in.Server(**more)
        self.addCleanup(self.server.close)
        return World(GzTransport(), name, step_secs, limit_secs)

    def pushed(self, world: World) -> str:
        """A cart that is pushed for 0.1 s and rolls on, as a recording."""
        recording = Recording({"/cart.x": "m"})
        world.reset()
        for tick in range(20):
            world.command("/cart/cmd_force", Double(data=3.0 if tick < 10 else 0.0))
            world.step(10)
            recording.row(world.time_secs, world.pose("cart")[0][0])
        return recording.text()

    def test_after_a_step_the_world_is_where_mechanics_says(self) -> None:
        world = self.world()
        lines = self.pushed(world).splitlines()
        time_secs, x_m = map(float, lines[10].split(","))
        self.assertEqual(time_secs, 0.1)
        # Explicit velocities: n (n + 1) / 2 times the acceleration of a step.
        self.assertAlmostEqual(x_m, 3.0 / 2.0 * 1e-6 * 100 * 101 / 2, delta=1e-12)
        self.assertAlmostEqual(float(lines[20].split(",")[1]) - x_m, 0.1 * 3.0 / 2.0 * 0.1, delta=1e-12)
        self.assertEqual(world.pose("cart")[1], (0.0, 0.0, 0.0, 1.0))

    def test_it_stands_between_steps(self) -> None:
        world = self.world(pose_hertz=1000.0)
        world.reset()
        world.command("/cart/cmd_force", Double(data=3.0))
        world.step(10)
        steps, came = self.server.steps, threading.Event()
        came.wait(0.1)
        self.assertEqual((self.server.steps, steps), (10, 10))

    def test_the_same_again_is_the_same_however_slow_the_server_is(self) -> None:
        first = self.pushed(self.world())
        for more in ({"pose_hertz": 1000.0}, {"pose_hertz": 20.0}, {"delay_secs": 0.01}):
            self.assertEqual(self.pushed(self.world(**more)), first)
        self.assertEqual(self.pushed(World(GzTransport(), "w", 0.001)), first)

    def test_a_reset_leads_back_to_the_beginning(self) -> None:
        world = self.world()
        first = self.pushed(world)
        self.assertEqual(self.server.warnings, [])
        self.assertEqual(self.pushed(world), first)
        world.reset(seed=2**32 + 5)
        self.assertEqual((world.time_secs, world.pose("cart")[0][0]), (0.0, 0.0))
        self.assertEqual(self.server.warnings, ["Changing seed is not supported."])

    def test_what_does_not_come_is_told(self) -> None:
        world = self.world(limit_secs=0.3, broadcasts=False)
        with self.assertRaisesRegex(TimeoutError, "no poses of 0 s .* none have come: does it have a SceneBroadcaster"):
            world.reset()
        world = self.world(limit_secs=0.3, step_secs=0.002)
        world.reset()
        with self.assertRaisesRegex(TimeoutError, "no poses of 0.02 s .* the last are of 0.01 s. Is 0.002 s its max_step_size"):
            world.step(10)

    def test_mistakes_are_named(self) -> None:
        with self.assertRaisesRegex(RuntimeError, "/world/other/control did not answer: is a world called `other` running"):
            self.world("other").step(1)
        world = self.world()
        self.server.refuses = True
        with self.assertRaisesRegex(RuntimeError, "control refused"):
            world.reset()
        world = self.world()
        world.reset()
        with self.assertRaisesRegex(KeyError, "no moving things are called `crate`; there are cart, wheel"):
            world.pose("crate")
        with self.assertRaisesRegex(KeyError, "2 moving things are called `wheel`"):
            world.pose("wheel")
        with self.assertRaisesRegex(ValueError, "at least 1 .got 0."):
            world.step(0)
        with self.assertRaisesRegex(ValueError, "positive"):
            World(GzTransport(), "w", 0.0)
        with self.assertRaisesRegex(RuntimeError, "gz.transport99 and gz.msgs10 of Gazebo cannot be imported"):
            GzTransport(99)

    def test_a_server_gets_the_seed_and_a_partition_and_ends(self) -> None:
        with tempfile.TemporaryDirectory() as room:
            program, said = Path(room) / "gz", Path(room) / "said"
            program.write_text(f'#!/bin/sh\necho "$@" "$GZ_PARTITION" $$ > {said}.part\nmv {said}.part {said}\nexec sleep 60\n')
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            self.world()
            with mock.patch.dict(os.environ, {"PATH": f"{room}:{os.environ['PATH']}"}):
                with served("a.sdf", seed=2**31 + 7) as transport:
                    World(transport, "w", 0.001).reset()
                    while not said.exists():
                        threading.Event().wait(0.01)
            *words, partition, number = said.read_text().split()
            self.assertEqual(words, ["sim", "-s", "--seed", "7", "a.sdf"])
            self.assertRegex(partition, "^corroborate-[0-9a-f]{32}$")
            with self.assertRaises(ProcessLookupError):
                os.kill(int(number), 0)
            with mock.patch.dict(os.environ, {"PATH": room + "/none"}):
                with self.assertRaisesRegex(RuntimeError, "`gz` was not found"), served("a.sdf", 1):
                    pass


if __name__ == "__main__":
    unittest.main()

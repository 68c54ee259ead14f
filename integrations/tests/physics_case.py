"""What holds in every physics, against formulas of mechanics: an adapter's test names its world and inherits these."""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))

GRAVITY_M_S2 = 9.81
BLOCK = """<robot name="block"><link name="block">
  <inertial><mass value="0.8"/>
    <inertia ixx="0.001387" iyy="0.001387" izz="0.00192" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.12 0.12 0.08"/></geometry></collision></link></robot>"""
SLIDER = """<robot name="slider"><link name="rail">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="carriage"><inertial><mass value="2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="-0.05 0 0.04"/><geometry><box size="0.1 0.2 0.06"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" effort="1000" velocity="100"/></joint></robot>"""


class PhysicsCase:
    """Mix it with `unittest.TestCase` and give it the adapter's `World`."""

    World: type

    def setUp(self) -> None:
        self.room = tempfile.TemporaryDirectory()
        self.addCleanup(self.room.cleanup)

    def urdf(self, name: str, text: str) -> Path:
        path = Path(self.room.name) / f"{name}.urdf"
        path.write_text(text, encoding="utf-8")
        return path

    def world(self, pair_friction: float, step_secs: float = 0.001):
        world = self.World(step_secs, self.World.surface_for(pair_friction))
        self.addCleanup(world.close)
        return world

    def pushed(self, world, friction: float, speed_m_s: float):
        """A block that a slider brings to a speed and lets go: its place, speed row by row until it rests."""
        surface = self.World.surface_for(friction)
        world.add("slider", self.urdf("slider", SLIDER), [0, 0, 0], True, surface)
        world.add("block", self.urdf("block", BLOCK), [0.0601, 0, 0.04], False, surface)
        rows = []
        for step in range(2500):
            _, velocity = world.joint("slider", "slide")
            wanted = min(speed_m_s, 4.0 * step * world.time_step_secs) if step < 500 else 0.0
            world.push("slider", "slide", max(-200.0, min(200.0, 400.0 * (wanted - velocity))))
            world.step()
            rows.append((world.position("block")[0], world.speed("block")))
        return rows

    def test_a_carriage_that_is_pushed_obeys_newton(self) -> None:
        world = self.world(0.3)
        world.add("slider", self.urdf("slider", SLIDER), [0, 0, 0], True, 0.3)
        for _ in range(500):
            world.push("slider", "slide", 3.0)
            world.step()
        position, velocity = world.joint("slider", "slide")
        self.assertAlmostEqual(velocity, 3.0 / 2.0 * 0.5, delta=1e-3)
        self.assertAlmostEqual(position, 0.5 * 1.5 * 0.5**2, delta=1e-3)

    def test_a_block_slides_as_far_as_friction_lets_it(self) -> None:
        for friction in (0.15, 0.3):
            rows = self.pushed(self.world(friction), friction, 1.0)
            # Alone and still fast, so that impact and release do not count; the speed is a mean, as the block rocks a little.
            middle, around = 560, 20
            speed = (rows[middle + around][0] - rows[middle - around][0]) / (2 * around * 0.001)
            expected = speed**2 / (2 * friction * GRAVITY_M_S2)
            with self.subTest(friction=friction):
                self.assertGreater(speed, 0.5)
                self.assertAlmostEqual((rows[-1][0] - rows[middle][0]) / expected, 1.0, delta=0.02)
                self.assertLess(rows[-1][1], 0.005)

    def test_a_block_at_rest_bears_its_weight_and_stays(self) -> None:
        world = self.world(0.3)
        world.add("block", self.urdf("block", BLOCK), [0, 0, 0.04], False, 0.3)
        world.add("shelf", self.urdf("shelf", BLOCK), [1, 0, 0.04], True, 0.3)
        world.add("parcel", self.urdf("parcel", BLOCK), [1, 0, 0.12], False, 0.3)
        for _ in range(1500):
            world.step()
        self.assertAlmostEqual(world.normal_force("parcel", "shelf"), 0.8 * GRAVITY_M_S2, delta=0.1)
        self.assertEqual(world.normal_force("block", "shelf"), 0.0)
        self.assertAlmostEqual(world.position("block")[2], 0.04, delta=2e-3)
        self.assertLess(math.hypot(*world.position("block")[:2]), 1e-3)

    def test_the_same_again_is_the_same_to_the_last_bit(self) -> None:
        first = self.pushed(self.world(0.3), 0.3, 1.0)
        self.pushed(self.world(0.1), 0.1, 0.5)
        self.assertEqual(self.pushed(self.world(0.3), 0.3, 1.0), first)

    def test_a_joint_that_is_not_there_is_named(self) -> None:
        world = self.world(0.3)
        world.add("slider", self.urdf("slider", SLIDER), [0, 0, 0], True, 0.3)
        with self.assertRaisesRegex(Exception, "glide"):
            world.push("slider", "glide", 1.0)
            world.step()

import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]

from physics_case import PhysicsCase  # noqa: E402
from pybullet_world import World  # noqa: E402


class TestPybullet(PhysicsCase, unittest.TestCase):
    World = World


if __name__ == "__main__":
    unittest.main()

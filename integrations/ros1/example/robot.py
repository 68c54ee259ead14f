"""A mobile base on a line with a laser scanner, driven by a ROS 1 node: `robot.py [--reset] [--real-time] [STIMULUS SEED RECORDING]`.

The base's x points forwards from where it starts (m, frame of the world). It follows `/cmd_vel` with a lag and brakes no harder than it
can. A crate stands on its way, or is put there when the base is at `crate.appears_m` before it.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from geometry_msgs.msg import Twist  # noqa: E402
from ros1_rig import Answer, Ros1Rig, main  # noqa: E402
from sensor_msgs.msg import LaserScan  # noqa: E402

TICK_SECS = 0.05
DURATION_SECS = 7.0
LAG_SECS = 0.15
BRAKE_M_S2 = 1.2
BEAMS = 9
FIELD_RAD = 0.6
RANGE_M = (0.05, 6.0)
NOISE_M = 0.01


class World:
    """The base, the crate and the laser."""

    signals = {
        "/truth/base.x": "m", "/truth/base.speed": "m/s", "/truth/base.gap": "m", "/truth/crate.there": "", "/stopper.commanded": "m/s",
    }
    settings = ("crate.x_m", "crate.appears_m")

    def reset(self, episode):
        """The base at rest at x = 0."""
        self.crate_m, self.appears_m = episode.number("crate.x_m"), episode.number("crate.appears_m", math.inf)
        self.noise = episode.draws("laser")
        self.x_m, self.speed_m_s, self.commanded_m_s, self.there = 0.0, 0.0, None, False
        return self._seen()

    def step(self, commands):
        """A tick: the last command acts with a first-order lag, within the brakes' limit."""
        if "/cmd_vel" in commands:
            self.commanded_m_s = commands["/cmd_vel"].linear.x
        wanted = ((self.commanded_m_s or 0.0) - self.speed_m_s) / LAG_SECS
        self.speed_m_s = max(0.0, self.speed_m_s + TICK_SECS * max(-BRAKE_M_S2, min(BRAKE_M_S2, wanted)))
        self.x_m += TICK_SECS * self.speed_m_s
        return self._seen()

    def row(self):
        """Values of the signals; the gap is to the crate's place, whether or not it stands there yet."""
        return self.x_m, self.speed_m_s, self.crate_m - self.x_m, self.there, self.commanded_m_s

    def _seen(self):
        """The laser: a wall at right angles, with noise."""
        gap = self.crate_m - self.x_m
        self.there = self.there or gap <= self.appears_m
        scan = LaserScan(angle_min=-FIELD_RAD / 2, angle_max=FIELD_RAD / 2, angle_increment=FIELD_RAD / (BEAMS - 1))
        scan.range_min, scan.range_max, scan.header.frame_id = *RANGE_M, "laser"
        for beam in range(BEAMS):
            clear = gap / math.cos(scan.angle_min + beam * scan.angle_increment) if self.there else math.inf
            scan.ranges.append(clear + self.noise.gauss(0.0, NOISE_M))
        return {"/scan": scan}


def rig(**more):
    """The base's nodes as its team launches them."""
    return Ros1Rig(
        World(), str(HERE / "base_stop/launch/base.launch"), {"/cmd_vel": Answer(Twist)}, TICK_SECS, DURATION_SECS,
        package_path=[HERE], **more,
    )


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    more = {"reset_service": "/stopper/reset"} if "--reset" in sys.argv else {}
    main(lambda: rig(real_time="--real-time" in sys.argv, **more), words)

"""Joins the robots' program to the physics simulation: sensors in, commands out."""

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from corroborate_controller import Controller, Enumeration, Inputs, Number, Outputs, Setup, run  # noqa: E402
from forager import STATES, Forager  # noqa: E402


class Robot(Controller):
    name, version = "forager", "1.0"
    reports = {"state": Enumeration(*STATES), "brought": Number("1"), "missed": Number("1")}

    def set_up(self, setup: Setup) -> None:
        self.number = int(setup.settings["number"])
        self.cameras = sorted(name for name in setup.sensors if name.startswith("camera"))
        lidar = setup.sensors[f"lidar{self.number}"]
        first, step = lidar.facts["first_angle_rad"], lidar.facts["angle_step_rad"]
        angles = [first + step * ray for ray in range(lidar.fields["ranges"].length)]
        draws = random.Random(f"{setup.seed} robot {self.number}")
        self.forager = Forager(setup.settings, angles, draws)
        self.pose = None
        self.ranges = None
        self.holding = False

    def tick(self, inputs: Inputs) -> Outputs:
        n = self.number
        pose = inputs.sensors.get(f"pose{n}")
        if pose is not None:
            self.pose = tuple(pose.values[key][0] for key in ("x", "y", "yaw"))
        ranges = inputs.numbers(f"lidar{n}", "ranges")
        if ranges is not None:
            self.ranges = ranges
        grip = inputs.sensors.get(f"grip{n}")
        if grip is not None:
            self.holding = bool(grip.values["holding"][0])
        bags = []
        for camera in self.cameras:
            seen = inputs.sensors.get(camera)
            if seen is not None and seen.values["seen"][0]:
                bags.append((seen.values["x"][0], seen.values["y"][0]))
        outputs = Outputs()
        if self.pose is None:
            return outputs.command(f"drive{n}", speed=0.0, turn_rate=0.0)
        speed, turn, cup = self.forager.tick(inputs.time_secs, self.pose, self.ranges, bags, self.holding)
        outputs.report(state=self.forager.state, brought=self.forager.brought, missed=self.forager.missed)
        outputs.command(f"drive{n}", speed=speed, turn_rate=turn)
        return outputs.command(f"cup{n}", suction=cup)


if __name__ == "__main__":
    run(Robot())

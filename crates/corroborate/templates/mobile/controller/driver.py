"""The program under test: drives to a goal, around what its lidar meets, slowly near it.

It believes its wheels for where it is. Of the directions that its lidar says are free it takes the one nearest to the goal's.
Replace it by your own: what a program gets and gives is in corroborate_controller/controller.py beside it.
"""

import math

from corroborate_controller import Controller, Enumeration, Inputs, Number, Outputs, Setup, run


class Driver(Controller):
    """States: wait for `go`, drive, slow, stop, arrived."""

    name, version = "driver", "1"
    receives = ("go",)
    sends = ("arrived",)
    # What it tells of its inside: recorded as /controller/driver.state and .ahead.
    reports = {"state": Enumeration("wait", "drive", "slow", "stop", "arrived"), "ahead": Number("m")}

    def set_up(self, setup: Setup) -> None:
        """A new episode; everything of an earlier one is forgotten."""
        facts = setup.sensors["lidar"].facts
        count = setup.sensors["lidar"].fields["ranges"].length
        self.angles = [facts["first_angle_rad"] + facts["angle_step_rad"] * ray for ray in range(count)]
        self.longest = facts["longest_m"]
        self.ranges = [self.longest] * count
        self.settings = setup.settings
        self.state = "wait"
        self.slow_until = 0.0
        self.x = self.y = self.yaw = 0.0

    def tick(self, inputs: Inputs) -> Outputs:
        """From what has arrived to what is commanded, ten times a second."""
        odometry = inputs.sensors.get("odometry")
        if odometry is not None:
            self.x, self.y, self.yaw = (odometry.values[name][0] for name in ("x", "y", "yaw"))
        ranges = inputs.numbers("lidar", "ranges")
        if ranges is not None:
            # A ray that met nothing is NaN.
            self.ranges = [self.longest if math.isnan(distance) else distance for distance in ranges]
        if inputs.heard("go") and self.state == "wait":
            self.state = "drive"
        outputs = Outputs()
        speed = turn_rate = 0.0
        ahead = self.free(0.0)
        if self.state not in ("wait", "arrived"):
            speed, turn_rate = self.drive(ahead, inputs.time_secs)
        if self.state == "arrived":
            outputs.send("arrived")
            outputs.finished = True
        return outputs.command("drive", speed=speed, turn_rate=turn_rate).report(state=self.state, ahead=ahead)

    def free(self, direction: float) -> float:
        """How far the robot could drive in a direction before it touched what a ray has met."""
        nearest = self.longest
        for angle, distance in zip(self.angles, self.ranges):
            beside = distance * math.sin(angle - direction)
            along = distance * math.cos(angle - direction)
            if along > 0 and abs(beside) < 0.4:
                nearest = min(nearest, along)
        return nearest

    def drive(self, ahead: float, now: float):
        """Speed and turn rate: towards the free direction that is nearest to the goal's."""
        to_goal = self.settings["goal_x_m"] - self.x, self.settings["goal_y_m"] - self.y
        distance = math.hypot(*to_goal)
        if distance < 0.3:
            self.state = "arrived"
            return 0.0, 0.0
        bearing = math.remainder(math.atan2(to_goal[1], to_goal[0]) - self.yaw, math.tau)
        wanted = min(distance, 1.8)
        directions = [0.1 * step for step in range(-12, 13)]
        best = min(directions, key=lambda turn: abs(turn - bearing) + 4.0 * max(0.0, wanted - self.free(turn)))
        turn_rate = max(-1.0, min(1.0, 1.5 * best))
        if ahead < self.settings["stop_distance_m"]:
            self.state = "stop"
            return 0.0, turn_rate
        if min(self.ranges) < self.settings["beside_distance_m"]:
            # What it has passed its lidar does not see any more.
            self.slow_until = now + 3.0
        if now < self.slow_until or ahead < self.settings["slow_distance_m"] or abs(best) > 0.6:
            self.state = "slow"
            return self.settings["slow_speed_m_s"], turn_rate
        self.state = "drive"
        return self.settings["cruise_speed_m_s"], turn_rate


if __name__ == "__main__":
    run(Driver())

"""Drives the carrier along its lane to the goal, slowly near what stands ahead, and stops before it.

It believes a lidar and its wheels. The wall on its right tells it how far it is off its lane. For people it looks ahead,
within `front_rad` of its heading and the width of its own way.
"""

import math

from corroborate_controller import Bool, Controller, Enumeration, Inputs, Number, Outputs, Setup, run


class Corridor(Controller):
    """States: wait for `go`, cruise, slow, stop, arrived."""

    name, version = "corridor", "1.0"
    receives = ("go",)
    sends = ("arrived",)
    reports = {
        "state": Enumeration("wait", "cruise", "slow", "stop", "arrived"),
        "ahead": Number("m"),
        "clear": Bool(),
    }

    def set_up(self, setup: Setup) -> None:
        lidar = setup.sensors["lidar"]
        count = lidar.fields["ranges"].length
        first, step = lidar.facts["first_angle_rad"], lidar.facts["angle_step_rad"]
        self.angles = [first + step * ray for ray in range(count)]
        self.longest = lidar.facts["longest_m"]
        self.settings = setup.settings
        self.state = "wait"
        self.ahead = self.longest
        self.clear_since = -math.inf
        self.off_lane = 0.0
        self.x, self.yaw = 0.0, 0.0

    def look(self, ranges) -> float:
        """How far the robot could drive before it touched what a ray met, within the sector ahead."""
        nearest = self.longest
        for angle, distance in zip(self.angles, ranges):
            if math.isnan(distance) or abs(angle) > self.settings["front_rad"]:
                continue
            beside = distance * math.sin(angle)
            if abs(beside) < self.settings["way_half_width_m"]:
                nearest = min(nearest, distance * math.cos(angle))
        return nearest

    def find_lane(self, ranges) -> float:
        """How far the robot is left of its lane: the middle of what the rays to the right say of the wall there."""
        rays = zip(self.angles, ranges)
        beside = sorted(-d * math.sin(a + self.yaw) for a, d in rays if a < -1.2 and not math.isnan(d))
        return beside[len(beside) // 2] - self.settings["lane_from_wall_m"] if beside else self.off_lane

    def tick(self, inputs: Inputs) -> Outputs:
        odometry = inputs.sensors.get("odometry")
        if odometry is not None:
            self.x = odometry.values["x"][0]
            self.yaw = odometry.values["yaw"][0]
        ranges = inputs.numbers("lidar", "ranges")
        if ranges is not None:
            self.ahead = self.look(ranges)
            self.off_lane = self.find_lane(ranges)
        if inputs.heard("go") and self.state == "wait":
            self.state = "cruise"
        if self.state in ("cruise", "slow", "stop"):
            self.decide(inputs.time_secs)
        outputs = Outputs(finished=self.state == "arrived")
        if self.state == "arrived":
            outputs.send("arrived")
        outputs.report(state=self.state, ahead=self.ahead, clear=self.state == "cruise")
        return outputs.command("drive", speed=self.speed(), turn_rate=self.turn_rate())

    def decide(self, now: float) -> None:
        """The next state. Cruising is resumed when nothing has been ahead for a while."""
        if self.x >= self.settings["goal_m"]:
            self.state = "arrived"
        elif self.ahead < self.settings["stop_distance_m"]:
            self.state, self.clear_since = "stop", now
        elif self.ahead < self.settings["slow_distance_m"]:
            self.state, self.clear_since = "slow", now
        elif now - self.clear_since >= self.settings["resume_secs"]:
            self.state = "cruise"
        else:
            self.state = "slow"

    def speed(self) -> float:
        """Commanded speed in m/s."""
        speeds = {"cruise": self.settings["cruise_speed_m_s"], "slow": self.settings["slow_speed_m_s"]}
        return speeds.get(self.state, 0.0)

    def turn_rate(self) -> float:
        """Back to the lane: the heading that closes the gap to it within about a metre and a half."""
        if self.state not in ("cruise", "slow"):
            return 0.0
        wanted = math.atan2(-self.off_lane, 1.5)
        return max(-1.0, min(1.0, 1.5 * (wanted - self.yaw)))


if __name__ == "__main__":
    run(Corridor())

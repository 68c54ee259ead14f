"""What a robot of the swarm does: it looks for jackets, takes one and brings it to the counter. No robot knows of another's plans.

The same program drives the robots of the physics simulation (`robot.py`) and those of the stand-in for reality
(`../reality/trials.py`). Nothing but what a robot senses goes in: where it believes it is, what its lidar meets, where its camera
sees a jacket's bag, and whether its cup holds.
"""

from __future__ import annotations

import math
import random
from typing import Mapping, Optional, Sequence, Tuple

STATES = ("search", "approach", "carry", "back_off")


def wrapped(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


class Forager:
    """`tick` once each period: what is sensed in, what is commanded out."""

    def __init__(self, settings: Mapping[str, float], angles: Sequence[float], draws: random.Random):
        self.settings = settings
        self.angles = angles
        self.draws = draws
        self.state = "search"
        self.since = 0.0
        self.heading = 0.0
        self.leg_ends = 0.0
        self.seen_at: Optional[Tuple[float, float, float]] = None
        self.turning = 0.0
        self.ahead = math.inf
        self.brought = 0
        self.missed = 0

    def begin(self, state: str, now: float) -> None:
        self.state, self.since, self.turning = state, now, 0.0

    def clearances(self, ranges: Sequence[float]) -> Tuple[float, float, float]:
        """How far it could drive ahead before its body touched, and the nearest to the left and to the right."""
        half, ahead, left, right = self.settings["way_half_width_m"], math.inf, math.inf, math.inf
        for angle, distance in zip(self.angles, ranges):
            if math.isnan(distance):
                continue
            along, beside = distance * math.cos(angle), distance * math.sin(angle)
            gap = distance - self.settings["body_radius_m"]
            if along > 0 and abs(beside) < half:
                ahead = min(ahead, along - self.settings["body_radius_m"])
            # What is beside it counts once it is very near.
            if abs(angle) < 1.3 and gap < self.settings["stop_m"]:
                ahead = min(ahead, gap)
            if abs(angle) < 1.9:
                if beside > 0:
                    left = min(left, distance)
                else:
                    right = min(right, distance)
        return ahead, left, right

    def tick(
        self,
        now: float,
        pose: Tuple[float, float, float],
        ranges: Optional[Sequence[float]],
        bags: Sequence[Tuple[float, float]],
        holding: bool,
    ) -> Tuple[float, float, float]:
        """Speed in m/s, turn rate in rad/s, and whether the cup sucks (0 or 1). `bags`: ahead and to the left of its middle."""
        s = self.settings
        x, y, yaw = pose
        left = right = math.inf
        if ranges is not None:
            self.ahead, left, right = self.clearances(ranges)
        self.look(now, pose, bags)
        if self.state == "search":
            if self.seen_at is not None:
                self.begin("approach", now)
            elif now >= self.leg_ends:
                self.heading = self.draws.uniform(-math.pi, math.pi)
                self.leg_ends = now + self.draws.uniform(s["shortest_leg_secs"], s["longest_leg_secs"])
        if self.state == "approach":
            if holding:
                self.begin("carry", now)
            elif self.seen_at is None or now - self.since > s["approach_secs"]:
                self.missed += 1
                self.seen_at = None
                self.begin("back_off", now)
        if self.state == "carry":
            if not holding:
                self.begin("search", now)
            elif x < s["drop_x_m"]:
                self.brought += 1
                self.begin("back_off", now)
        if self.state == "back_off" and now - self.since > s["back_off_secs"]:
            self.heading = self.draws.uniform(-1.0, 1.0)
            self.leg_ends = now + s["longest_leg_secs"]
            self.seen_at = None
            self.begin("search", now)
        return self.move(now, x, y, yaw, left, right)

    def look(self, now: float, pose: Tuple[float, float, float], bags: Sequence[Tuple[float, float]]) -> None:
        """Remembers where it last saw the nearest bag that is not at the counter."""
        s = self.settings
        x, y, yaw = pose
        nearest = math.inf
        for ahead, left in bags:
            there_x = x + ahead * math.cos(yaw) - left * math.sin(yaw)
            there_y = y + ahead * math.sin(yaw) + left * math.cos(yaw)
            distance = math.hypot(ahead, left)
            if there_x > s["store_from_x_m"] and distance < nearest:
                nearest = distance
                self.seen_at = (there_x, there_y, now)
        if self.seen_at is not None and now - self.seen_at[2] > s["forget_secs"]:
            self.seen_at = None

    def move(self, now: float, x: float, y: float, yaw: float, left: float, right: float) -> Tuple[float, float, float]:
        s = self.settings
        if self.state == "back_off":
            turn = 1.5 if now - self.since > 0.6 * s["back_off_secs"] else 0.0
            return -s["slow_speed_m_s"], turn, 0.0
        cup = 1.0 if self.state in ("approach", "carry") else 0.0
        if self.state == "approach" and self.seen_at is not None:
            off = wrapped(math.atan2(self.seen_at[1] - y, self.seen_at[0] - x) - yaw)
            distance = math.hypot(self.seen_at[0] - x, self.seen_at[1] - y)
            speed = s["slow_speed_m_s"] if distance < 0.45 else s["cruise_speed_m_s"]
            if abs(off) > 0.3:
                speed = 0.0
        else:
            if self.state == "carry":
                wanted = math.pi
            else:
                # It keeps off the counter while it searches.
                wanted = self.heading
                if x < s["store_from_x_m"] and abs(wrapped(wanted)) > 1.2:
                    self.heading = self.draws.uniform(-1.0, 1.0)
                    wanted = self.heading
            off = wrapped(wanted - yaw)
            speed = s["cruise_speed_m_s"] * max(0.0, math.cos(off))
        turn = max(-s["turn_rate_rad_s"], min(s["turn_rate_rad_s"], 2.5 * off))
        # What is in the way: to the freer side, and on past it.
        if self.ahead < s["avoid_m"]:
            if self.turning == 0.0:
                self.turning = 1.0 if left >= right else -1.0
            speed = 0.0 if self.ahead < s["stop_m"] else 0.5 * s["slow_speed_m_s"]
            turn = self.turning * s["turn_rate_rad_s"]
            if self.state == "search":
                self.heading = yaw + self.turning * 1.2
                self.leg_ends = max(self.leg_ends, now + s["shortest_leg_secs"])
        elif self.turning != 0.0:
            speed, turn = 0.7 * s["cruise_speed_m_s"], 0.0
            if self.ahead > s["avoid_m"] + 0.3 or self.draws.random() < 0.1:
                self.turning = 0.0
        return speed, turn, cup

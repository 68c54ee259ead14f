"""The program of the cell, without what joins it to a simulation: moves parts from bin A to bin B, slowly while it knows of a person.

It is the program under test: `cell.py` joins it to the tool's scene, and the simulators of this study call it as it is. It believes
its scanner (how far off somebody is), the force at its wrist and whether its gripper holds something; nothing else.
"""

import math

# The arm as the program knows it (m): height of the shoulder over the table, upper arm, forearm, wrist to the fingers' middle.
SHOULDER_M, UPPER_M, FORE_M, TOOL_M = 0.20, 0.38, 0.34, 0.165
# Bins: angle of the column (rad) of each part and of each place, and the radius at which they lie (m).
PARTS_RAD = (-0.95, -0.80, -0.65, -0.50)
PLACES_RAD = (0.50, 0.65, 0.80, 0.95)
RADIUS_M = 0.55
# Heights of the fingers' middle over the table (m): on the way, and at a part.
HIGH_M, LOW_M = 0.18, 0.05
WIDE_M, NARROW_M = 0.08, 0.0


def joints(angle_rad, radius_m, height_m):
    """Joint positions (turn, lift, elbow, wrist) with the gripper pointing down at this place."""
    up_m = height_m + TOOL_M - SHOULDER_M
    reach_m = math.hypot(radius_m, up_m)
    cosine = (reach_m**2 - UPPER_M**2 - FORE_M**2) / (2 * UPPER_M * FORE_M)
    elbow = math.acos(max(-1.0, min(1.0, cosine)))
    lift = math.atan2(radius_m, up_m) - math.atan2(FORE_M * math.sin(elbow), UPPER_M + FORE_M * math.cos(elbow))
    return angle_rad, lift, elbow, math.pi - lift - elbow


def points(turn, lift, elbow, wrist):
    """Where shoulder, elbow, wrist and the fingers' middle are (x, y, z over the table) for these joint positions."""
    place, tilt, radius, height = [], 0.0, 0.0, SHOULDER_M
    place.append((0.0, 0.0, height))
    for angle, length in ((lift, UPPER_M), (elbow, FORE_M), (wrist, TOOL_M)):
        tilt += angle
        radius += length * math.sin(tilt)
        height += length * math.cos(tilt)
        place.append((radius * math.cos(turn), radius * math.sin(turn), height))
    return place


class Program:
    """States: work, careful, back_off, stand, done."""

    STATES = ("work", "careful", "back_off", "stand", "done")

    def __init__(self, settings, period_secs):
        self.settings, self.period_secs = settings, period_secs
        self.state = "work"
        self.parts = self.lost = self.number = 0
        self.near_until = -1.0
        self.calm_from = 0.0
        self.speed_m_s = 0.0
        self.place = self.start = (PARTS_RAD[0], RADIUS_M, HIGH_M)
        self.grip_until = None
        self.width_m = WIDE_M
        self.holds = False
        self.plan = self.cycle()

    def cycle(self):
        """The steps of one part: where to go, or how wide to open the fingers; and what is looked at then."""
        part, place = PARTS_RAD[self.number], PLACES_RAD[self.number]
        return [
            ("go", (part, RADIUS_M, HIGH_M)), ("go", (part, RADIUS_M, LOW_M)), ("grip", NARROW_M),
            ("go", (part, RADIUS_M, HIGH_M)), ("look", "lifted"), ("go", (place, RADIUS_M, HIGH_M)), ("look", "carried"),
            ("go", (place, RADIUS_M, LOW_M)), ("grip", WIDE_M), ("go", (place, RADIUS_M, HIGH_M)), ("look", "placed"),
        ]

    def tick(self, now, distance_m, force_n, holds):
        """What is commanded now. `distance_m` is None unless the scanner has said something: then infinite where nobody is seen."""
        if holds is not None:
            self.holds = holds
        if distance_m is not None and distance_m < self.settings["careful_distance_m"]:
            self.near_until = now + self.settings["hold_secs"]
        if self.state == "done":
            return
        settled = now > self.settings["settle_secs"]
        if settled and force_n is not None and force_n > self.settings["contact_n"] and self.state in ("work", "careful"):
            self.state, self.calm_from = "back_off", now
        if self.state == "back_off":
            self.back_off(now)
        elif self.state == "stand":
            self.speed_m_s = 0.0
            if now - self.calm_from >= self.settings["stand_secs"]:
                self.state = "careful"
        else:
            self.state = "careful" if now < self.near_until else "work"
            self.advance(now)

    def back_off(self, now):
        """Back the way it came, for a moment; then it stands."""
        self.speed_m_s = 0.0
        self.place = self.towards(self.start, self.settings["careful_m_s"] * self.period_secs)
        if now - self.calm_from >= self.settings["back_off_secs"]:
            self.state, self.calm_from = "stand", now

    def advance(self, now):
        """Goes on with the plan."""
        kind, what = self.plan[0]
        if kind == "look":
            self.look(what)
        elif kind == "grip":
            self.width_m = what
            if self.grip_until is None:
                self.grip_until = now + self.settings["grip_secs"]
            if now >= self.grip_until:
                self.grip_until = None
                self.plan.pop(0)
        else:
            self.go(what)

    def look(self, what):
        """What the gripper says at the end of a step: whether a part was lost, or is placed."""
        self.plan.pop(0)
        if what == "placed":
            self.parts += 1
        elif not self.holds:
            self.lost += 1
            self.width_m = WIDE_M
        else:
            return
        self.number += 1
        if self.parts >= self.settings["parts"] or self.number >= len(PARTS_RAD):
            self.state = "done"
        else:
            self.plan = self.cycle()

    def go(self, goal):
        """Towards a place, at most at the speed that is allowed, braking in time."""
        fastest = self.settings["careful_m_s" if self.state == "careful" else "full_m_s"]
        step = self.settings["acceleration_m_s2"] * self.period_secs
        left = self.length(self.place, goal)
        braking = math.sqrt(2 * self.settings["acceleration_m_s2"] * left)
        wanted = min(fastest, braking, self.speed_m_s + step)
        self.speed_m_s = max(wanted, min(self.speed_m_s - 2 * step, braking))
        moved = self.speed_m_s * self.period_secs
        if left <= max(moved, 1e-3):
            self.place = self.start = goal
            self.speed_m_s = 0.0
            self.plan.pop(0)
        else:
            self.place = self.towards(goal, moved)

    @staticmethod
    def length(a, b):
        """How long the way of the fingers is from a to b."""
        return math.hypot((b[0] - a[0]) * RADIUS_M, b[1] - a[1], b[2] - a[2])

    def towards(self, goal, moved_m):
        """A place that much nearer to a goal."""
        left = self.length(self.place, goal)
        share = 1.0 if left <= moved_m or left == 0.0 else moved_m / left
        return tuple(now + share * (to - now) for now, to in zip(self.place, goal))

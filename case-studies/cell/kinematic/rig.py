"""A small kinematic simulation of the cell: places and speeds, no masses. An outside simulator of this study.

    rig.py STIMULUS SEED RECORDING

runs one episode and leaves a table in CSV; without arguments it takes episodes line by line. The program under test is
`controller/program.py`, as it is. Assumed: the arm follows its set points with a short lag, a person is a cylinder with two arms
that stretch forwards, an impact has the force v sqrt(K mu) of ISO/TS 15066 (annex A.3), and a hand that is pushed aside presses back
like the spring by which it is held. What is not here: gripping, clamping, balance, the person's head and legs.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "controller"), str(HERE.parent.parent.parent / "integrations" / "common")]

from corroborate_rig import Episode, Recording, main  # noqa: E402
from program import RADIUS_M, Program, joints, points  # noqa: E402

STEP_SECS, ROW_STEPS, DURATION_SECS, END_AFTER_SECS = 0.01, 2, 20.0, 0.2
TABLE_M, SCANNER_X_M, TRUNK_M, HAND_M, FORE_M, TOOL_M = 0.75, 0.80, 0.22, 0.05, 0.04, 0.05
LAG_SECS, SCAN_SECS = 0.05, 0.05
# ISO/TS 15066, annex A.3: effective mass (kg) and spring constant (N/m) of a hand; half of the arm's moving mass (kg).
HAND_KG, HAND_N_M, ARM_KG = 0.6, 75_000.0, 3.3
IMPACT_NS_M = math.sqrt(HAND_N_M / (1 / HAND_KG + 1 / ARM_KG))
HELD_N_M, HELD_MOST_N, HAND_WEIGHT_N = 300.0, 80.0, 10.0
SIGNALS = {
    "/truth/anna.x": "m",
    "/truth/arm.distance_to.people": "m",
    "/truth/arm/tip.speed": "m/s",
    "/truth/arm.contact.people.normal_force": "N",
    "/controller/cell.state": "",
    "/controller/cell.parts": "",
    "/controller/cell.lost": "",
}


class Person:
    """Who comes to the table, stretches both arms over it, and leaves."""

    def __init__(self, episode):
        number = episode.number
        self.x_m, self.y_m = number("person.x_m"), number("person.y_m")
        self.at_x_m = number("person.at_x_m")
        self.speed_m_s, self.starts_secs = number("person.speed_m_s"), number("person.starts_secs")
        self.stays_secs, self.hand_m_s = number("person.stays_secs"), number("person.hand_m_s")
        height_m, shoulder_rad = number("person.height_m"), number("person.shoulder_rad") + number("person.shoulder_more_rad")
        self.shoulder_m, arm_m = 0.82 * height_m, 0.44 * height_m
        self.reach_m, self.hand_height_m = arm_m * math.sin(shoulder_rad), self.shoulder_m - arm_m * math.cos(shoulder_rad)
        self.again = episode.draws("again").random() < number("person.comes_again_probability")
        self.stretched_m, self.left_at = 0.0, None

    def step(self, now):
        """Ten milliseconds."""
        if now >= self.starts_secs:
            if self.left_at is None and self.x_m <= self.at_x_m:
                self.left_at = now + self.stays_secs
            if self.left_at is None:
                self.x_m -= self.speed_m_s * STEP_SECS
            elif now >= self.left_at:
                self.x_m += self.speed_m_s * STEP_SECS
                if self.again and self.x_m > 2.4:
                    self.again, self.left_at = False, None
        wanted = self.reach_m if self.x_m < 1.45 else 0.0
        most = self.hand_m_s * STEP_SECS
        self.stretched_m += max(-most, min(most, wanted - self.stretched_m))

    def balls(self):
        """Hands and the middle of the forearms: centre and radius."""
        share = self.stretched_m / self.reach_m
        height = 0.95 + share * (self.hand_height_m - 0.95)
        for side in (-0.2, 0.2):
            hand = (self.x_m - self.stretched_m, self.y_m + side, height)
            yield hand, HAND_M
            yield ((hand[0] + 0.25 * share, hand[1], hand[2] + 0.12), HAND_M)


def to_segment(point, a, b):
    """The distance of a point from a segment."""
    along = [q - p for p, q in zip(a, b)]
    square = sum(d * d for d in along)
    share = max(0.0, min(1.0, sum((p - q) * d for p, q, d in zip(point, a, along)) / square))
    return math.dist(point, [q + share * d for q, d in zip(a, along)])


def distance(place, person):
    """Between the arm and the person, and between the arm and the nearest hand (m); where its set points put the arm."""
    at = [(x, y, z + TABLE_M) for x, y, z in points(*joints(*place))]
    links = ((at[1], at[2], FORE_M), (at[2], at[3], TOOL_M))
    trunk = min(math.hypot(x - person.x_m, y - person.y_m) for x, y, _ in at[2:]) - TRUNK_M - TOOL_M
    near = min(to_segment(ball, a, b) - radius - link for ball, radius in person.balls() for a, b, link in links)
    return min(trunk, near), near


def run(episode):
    """One visit."""
    number = episode.number
    settings = {key[8:]: value for key, value in episode.settings.items() if key.startswith("program.")}
    program, person = Program(settings, STEP_SECS), Person(episode)
    scanner, grip = episode.draws("scanner"), episode.draws("grip")
    blind = scanner.random() < number("scanner.blind_probability")
    slips = [grip.random() < number("grip.slip_probability") for _ in range(4)]
    recording, place, before = Recording(SIGNALS), program.place, program.place
    scans, pushed_m, force_n, gap_m, ends = [], 0.0, 0.0, 9.0, None
    for step in range(round(DURATION_SECS / STEP_SECS) + 1):
        now = step * STEP_SECS
        person.step(now)
        if step % round(SCAN_SECS / STEP_SECS) == 0:
            far = person.x_m - TRUNK_M - SCANNER_X_M
            seen = far < 3.0 and scanner.random() < number("scanner.detection_probability")
            seen = seen and not (blind and far > number("scanner.blind_until_m"))
            scans.append((now + scanner.uniform(0.06, 0.12), far + scanner.gauss(0.0, 0.02) if seen else math.inf))
        arrived = None
        while scans and scans[0][0] <= now:
            arrived = scans.pop(0)[1]
        holds = program.width_m < 0.01 and not slips[program.number]
        program.tick(now, arrived, HAND_WEIGHT_N + force_n, holds)
        place = tuple(p + (w - p) * STEP_SECS / LAG_SECS for p, w in zip(place, program.place))
        if step % ROW_STEPS == 0:
            near, hands = distance(place, person) if person.x_m < 1.9 else (person.x_m - 0.9, 9.0)
            closing = max(0.0, (gap_m - hands) / (STEP_SECS * ROW_STEPS))
            pushed_m = max(0.0, -hands)
            first = hands <= 0.0 < gap_m
            force_n = closing * IMPACT_NS_M if first else min(HELD_MOST_N, HELD_N_M * pushed_m)
            speed = math.hypot((place[0] - before[0]) * RADIUS_M, place[1] - before[1], place[2] - before[2])
            speed /= STEP_SECS * ROW_STEPS
            before, gap_m = place, hands
            recording.row(now, person.x_m, max(0.0, near), speed, force_n, program.state, program.parts, program.lost)
            if ends is None and program.state == "done":
                ends = now + END_AFTER_SECS
            if ends is not None and now >= ends:
                break
    return recording


if __name__ == "__main__":
    main(run)

"""The stand-in for reality: no robot and no person was there. It takes the place of the workshop in which trials would be made.

    stand_in.py trials [FOLDER]          writes the tables of trials of both series into the folder (experiments)
    stand_in.py recordings [FOLDER]      writes the recordings of the third series, with their faults, into the folder (recordings)
    stand_in.py truth [PEOPLE] [SEED]    prints the rates to which trials of this kind tend, with their standard errors

Nobody who makes a model of the cell may read on: what follows is hidden from formal model, scene and rig, as a workshop's truth is.
The program under test is `controller/program.py`, as it is, and the drawing of the cell (bins, arm, table, scanner) is known to all.

What is different here from what the models take for granted:

* Some people wear dark cloth at some visits. The scanner then sees them late, and each person does so more or less often.
* The arm is a driven mass with limited force, which lags, overshoots and brakes later than its data sheet says.
* Hands move as hands do (minimum jerk), to a place at which they want to be, at a speed of each person's own.
* A hand's skin is a spring that hardens (force as depth^1.5), and force is limited by the drive, the hand's mass and the hold.
* Parts are sometimes oily, and slip in the fingers at a rate that depends on their weight.
* One visitor in eight comes back a second time. The wrist's sensor has a bias that changes from day to day.
"""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
STUDY = HERE.parent
sys.path.insert(0, str(STUDY / "controller"))

from program import RADIUS_M, Program, joints, points  # noqa: E402

SEED = 15066
# Series: people, visits of each. The first is for calibration, the second is held out, the third is recorded.
SERIES = {"first": (24, 10), "second": (24, 10), "third": (16, 1)}
# What was wrong with the instruments of the third series, by the number of the recording.
GAPS, BIASED, CUT_SHORT = {4: 6.0, 11: 9.5}, (7, 8), 14
GAP_SECS, GLOVE_BIAS_N, CUT_SHARE = 1.2, 2.5, 0.6
SETTINGS = {
    "full_m_s": 1.5,
    "careful_m_s": 0.22,
    "acceleration_m_s2": 4.0,
    "careful_distance_m": 1.2,
    "hold_secs": 0.5,
    "contact_n": 40.0,
    "settle_secs": 0.3,
    "back_off_secs": 0.3,
    "stand_secs": 1.0,
    "grip_secs": 0.4,
    "parts": 3,
}
STEP_SECS, DURATION_SECS, END_AFTER_SECS = 0.01, 20.0, 0.2
TABLE_M, SCANNER_X_M = 0.75, 0.80
# The limits by which trials are judged, as requirements.toml and parameters.toml have them.
NEAR_M, SLOW_M_S, TABLE_PLACE_M, NOTICE_SECS = 0.25, 0.25, 1.45, 0.2
TRANSIENT_N, QUASI_STATIC_N, TRANSIENT_SECS, WORK_SECS = 280.0, 140.0, 0.5, 16.0


class Someone:
    """What one person is like, over all visits."""

    def __init__(self, draws):
        self.dark = draws.betavariate(0.9, 4.1)
        self.walk_m_s = max(0.7, draws.gauss(1.25, 0.18))
        self.hand_secs = max(0.45, draws.gauss(0.75, 0.12))
        self.height_m = min(1.95, max(1.5, draws.gauss(1.72, 0.09)))
        self.eager = draws.gauss(0.0, 0.035)


class Visit:
    """One visit: where the person and the hands are."""

    def __init__(self, someone, draws):
        self.draws, self.someone = draws, someone
        self.x_m, self.y_m = draws.uniform(2.6, 3.0), draws.uniform(0.0, 0.4)
        self.stand_m = draws.uniform(1.06, 1.2)
        self.walk_m_s = max(0.6, draws.gauss(someone.walk_m_s, 0.1))
        self.starts_secs, self.stays_secs = draws.uniform(0.5, 7.0), 1.2 + draws.lognormvariate(0.5, 0.35)
        self.again = draws.random() < 0.125
        dark = draws.random() < someone.dark
        self.seen_within_m = draws.uniform(0.05, 0.75) if dark else 9.0
        self.leaves_secs, self.hand_from = None, None
        reach = min(0.62, max(0.3, draws.gauss(0.49, 0.06) + someone.eager))
        self.reach_m, self.height_m = reach, 0.81 * someone.height_m - math.sqrt(max(0.1, (0.43 * someone.height_m) ** 2 - reach**2))
        self.lead = draws.choice((-1, 1))

    def step(self, now):
        """Ten milliseconds."""
        if now < self.starts_secs:
            return
        if self.leaves_secs is None:
            self.x_m -= self.walk_m_s * STEP_SECS
            if self.hand_from is None and self.x_m < 1.5:
                self.hand_from = now
            if self.x_m <= self.stand_m:
                self.leaves_secs = now + self.stays_secs
        elif now >= self.leaves_secs:
            self.x_m += self.walk_m_s * STEP_SECS
            if self.again and self.x_m > 2.4:
                self.again, self.leaves_secs, self.hand_from = False, None, None

    def stretched(self, now):
        """How far the leading hand is out (m): there and back, as hands move."""
        if self.hand_from is None:
            return 0.0
        out = smooth((now - self.hand_from) / self.someone.hand_secs)
        if self.leaves_secs is not None:
            out -= smooth((now - self.leaves_secs + 0.3) / self.someone.hand_secs)
        return self.reach_m * max(0.0, out)

    def hands(self, now):
        """Both hands: the leading one all the way, the other four fifths of it, at its side."""
        out = self.stretched(now)
        share = out / self.reach_m
        height = 1.0 + share * (self.height_m - 1.0)
        for side, much in ((0.18 * self.lead, 1.0), (-0.18 * self.lead, 0.8)):
            yield (self.x_m - much * out, self.y_m + side, height)


def smooth(share):
    """Minimum jerk, from 0 to 1."""
    share = max(0.0, min(1.0, share))
    return share**3 * (10 - 15 * share + 6 * share**2)


class Arm:
    """The arm in its own coordinates (angle as a length, radius, height): a mass on a drive of limited force."""

    MASS_KG, HERTZ, DAMPING, MOST_N = 3.8, 3.4, 0.75, 70.0

    def __init__(self, place):
        self.at = [place[0] * RADIUS_M, place[1], place[2]]
        self.speed = [0.0, 0.0, 0.0]

    def step(self, place, push, secs):
        """Towards the set points, pushed by the force `push` along its coordinates."""
        turn = 2 * math.pi * self.HERTZ
        for axis, wanted in enumerate((place[0] * RADIUS_M, place[1], place[2])):
            force = self.MASS_KG * (turn**2 * (wanted - self.at[axis]) - 2 * self.DAMPING * turn * self.speed[axis])
            force = max(-self.MOST_N, min(self.MOST_N, force)) + push[axis]
            self.speed[axis] += force / self.MASS_KG * secs
            self.at[axis] += self.speed[axis] * secs

    def place(self):
        """As the program has places: angle, radius, height."""
        return self.at[0] / RADIUS_M, self.at[1], self.at[2]


class Hand:
    """A hand that the arm touches: how far it is pushed out of its way, and the force on it."""

    MASS_KG, HELD_N_M, HELD_NS_M, HELD_MOST_N, SKIN_N = 0.55, 380.0, 18.0, 90.0, 1.6e6

    def __init__(self):
        self.pushed_m = self.speed_m_s = 0.0

    def press(self, gap_m, closing_m_s, secs):
        """The force (N) for a time, where the arm's surface would be `gap_m` from the hand if nothing pushed it. The time is
        cut into short steps, in which arm and hand go on as they did."""
        most, total, count = 0.0, 0.0, 20
        for number in range(count):
            depth = max(0.0, -(gap_m - closing_m_s * secs * (number / count - 1)) - self.pushed_m)
            force = min(900.0, self.SKIN_N * depth**1.5)
            hold = min(self.HELD_MOST_N, max(-self.HELD_MOST_N, self.HELD_N_M * self.pushed_m + self.HELD_NS_M * self.speed_m_s))
            self.speed_m_s += (force - hold) / self.MASS_KG * secs / count
            self.pushed_m = max(0.0, self.pushed_m + self.speed_m_s * secs / count)
            if self.pushed_m == 0.0 and self.speed_m_s < 0.0:
                self.speed_m_s = 0.0
            most, total = max(most, force), total + force / count
        return most, total


def nearest(point, a, b):
    """The distance of a point from a segment, and the direction from the segment to it."""
    along = [q - p for p, q in zip(a, b)]
    share = sum((p - q) * d for p, q, d in zip(point, a, along)) / sum(d * d for d in along)
    share = max(0.0, min(1.0, share))
    way = [p - q - share * d for p, q, d in zip(point, a, along)]
    length = math.hypot(*way)
    return length, [w / max(length, 1e-9) for w in way]


def visit(someone, draws, keep=None):
    """One trial. What it showed: a truth value or None (did not come up) by requirement and way to fail. `keep` gets rows."""
    person, program = Visit(someone, draws), Program(SETTINGS, STEP_SECS)
    arm, hands = Arm(program.place), (Hand(), Hand())
    bias_n = draws.gauss(0.0, 4.0)
    weights = [draws.lognormvariate(math.log(0.45), 0.25) for _ in range(4)]
    frictions = [draws.uniform(0.06, 0.16) if draws.random() < 0.02 else draws.uniform(0.3, 0.6) for _ in range(4)]
    slips = [2 * f * 25.0 < w * (9.81 + 4.0) for f, w in zip(frictions, weights)]
    scans, scan_at, felt_n, gaps = [], draws.uniform(0.0, 0.05), 0.0, [9.0, 9.0]
    judged = Judge()
    for step in range(round(DURATION_SECS / STEP_SECS) + 1):
        now = step * STEP_SECS
        person.step(now)
        if now >= scan_at:
            scan_at += 0.05
            far = person.x_m - 0.21 - SCANNER_X_M
            seen = far < min(3.0, person.seen_within_m) and draws.random() < 0.97
            scans.append((now + draws.uniform(0.07, 0.15), far + draws.gauss(0.0, 0.03) if seen else math.inf))
        arrived = None
        while scans and scans[0][0] <= now:
            arrived = scans.pop(0)[1]
        holds = program.width_m < 0.01 and not slips[program.number]
        program.tick(now, arrived, 10.0 + bias_n + felt_n, holds)
        at = [(x, y, z + TABLE_M) for x, y, z in points(*joints(*arm.place()))]
        push, hardest, distance = [0.0, 0.0, 0.0], 0.0, person.x_m - 0.9
        if person.x_m < 1.9:
            felt_n, distance = 0.0, min(math.hypot(x - person.x_m, y - person.y_m) for x, y, _ in at[2:]) - 0.26
            for number, place in enumerate(person.hands(now)):
                wrist, way = nearest(place, at[2], at[3])
                fore, back = nearest(place, at[1], at[2])
                gap, way, at_tool = (wrist - 0.095, way, True) if wrist - 0.01 < fore else (fore - 0.085, back, False)
                closing = min(3.0, max(-3.0, (gaps[number] - gap) / STEP_SECS)) if gaps[number] < 1.0 else 0.0
                gaps[number] = gap
                distance = min(distance, gap)
                if gap > 0.02 and hands[number].pushed_m == 0.0:
                    continue
                most, mean = hands[number].press(gap, closing, STEP_SECS)
                hardest = max(hardest, most)
                felt_n += mean if at_tool else 0.0
                turn = arm.place()[0]
                across = -way[0] * math.sin(turn) + way[1] * math.cos(turn)
                outwards = way[0] * math.cos(turn) + way[1] * math.sin(turn)
                push = [p - mean * w for p, w in zip(push, (across, outwards, way[2]))]
        arm.step(program.place, push, STEP_SECS)
        speed = math.hypot(*arm.speed)
        judged.row(now, person.x_m, max(0.0, distance), speed, hardest, program)
        if keep is not None and step % 2 == 0:
            keep.append((now, person.x_m, max(0.0, distance), speed, judged.hardest_n, program.state, program.parts, program.lost))
            judged.hardest_n = 0.0
        if judged.ended(now):
            break
    return judged.verdicts()


class Judge:
    """Says of a trial what an observer with perfect instruments would write down."""

    def __init__(self):
        self.touched = self.lost = self.moved = self.fast = self.hard = False
        self.near = self.pressed = self.long = self.unnoticed = False
        self.at_table_from = self.pressed_from = self.done_at = None
        self.inside = self.careful = False
        self.hardest_n = 0.0

    def row(self, now, x_m, distance_m, speed_m_s, force_n, program):
        """What there is to see now."""
        self.hardest_n = max(self.hardest_n, force_n)
        careful = program.state != "work"
        if x_m < TABLE_PLACE_M and not self.inside:
            self.at_table_from = now
        self.inside = x_m < TABLE_PLACE_M
        if self.at_table_from is not None:
            if careful:
                self.at_table_from = None
            elif now - self.at_table_from > NOTICE_SECS:
                self.unnoticed, self.at_table_from = True, None
        self.touched = self.touched or force_n > 1.0
        if distance_m < NEAR_M and not self.touched:
            self.near = True
            self.fast = self.fast or speed_m_s > SLOW_M_S
        self.hard = self.hard or force_n > TRANSIENT_N
        if force_n > QUASI_STATIC_N:
            self.pressed = True
            self.pressed_from = now if self.pressed_from is None else self.pressed_from
            self.long = self.long or now - self.pressed_from > TRANSIENT_SECS
        else:
            self.pressed_from = None
        self.lost = self.lost or program.lost > 0
        self.moved = self.moved or (program.parts >= 3 and now <= WORK_SECS)
        if program.state == "done" and self.done_at is None:
            self.done_at = now

    def ended(self, now):
        """Whether the trial is over before its time."""
        return self.done_at is not None and now >= self.done_at + END_AFTER_SECS

    def verdicts(self):
        """By requirement whether it is satisfied (None: it did not come up), and by way to fail whether it occurred."""
        return {
            "separation": not self.fast if self.near else None,
            "transient": not self.hard,
            "quasi_static": not self.long if self.pressed else None,
            "work": self.moved,
            "unnoticed": self.unnoticed,
            "struck": self.touched,
            "lost": self.lost,
        }


REQUIREMENTS, MODES = ("separation", "transient", "quasi_static", "work"), ("unnoticed", "struck", "lost")


def people(series, count, seed=SEED):
    """The people of a series, each with random numbers of its own."""
    for number in range(1, count + 1):
        yield number, random.Random(f"{seed} {series} {number}")


def write(path, lines):
    """A file with these lines."""
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def trials(folder):
    """The tables of the first and the second series."""
    for series in ("first", "second"):
        count, visits = SERIES[series]
        cohort, all_of_them = ["subject,attempts,moved,unnoticed,struck,lost"], []
        for number, draws in people(series, count):
            someone = Someone(draws)
            seen = [visit(someone, draws) for _ in range(visits)]
            counts = [sum(v[key] for v in seen) for key in ("work", "unnoticed", "struck", "lost")]
            cohort.append(",".join(map(str, (f"{series[0]}{number}", visits, *counts))))
            all_of_them += seen
        write(folder / f"{series}_cohort.csv", cohort)
        lines = ["requirement,covered,passed,failed"]
        for key in REQUIREMENTS:
            came_up = [v[key] for v in all_of_them if v[key] is not None]
            lines.append(f"{key},{len(came_up)},{sum(came_up)},{len(came_up) - sum(came_up)}")
        write(folder / f"{series}_requirements.csv", lines)
        lines = ["mode,occurrences,opportunities"]
        lines += [f"{key},{sum(v[key] for v in all_of_them)},{len(all_of_them)}" for key in MODES]
        write(folder / f"{series}_failure_modes.csv", lines)


HEADER = "time_s,person_x_mm,distance_mm,tool_speed_mm_per_s,glove_n,state,parts,lost"


def recorded(number, rows, draws):
    """The lines of a recording: what instruments made of a visit. Clocks jitter, markers are hidden now and then; some recordings have a gap, a glove that was not zeroed, or no end."""
    lines, hidden_until, before = [HEADER], 0.0, -1.0
    for now, x_m, distance_m, speed_m_s, force_n, state, parts, lost in rows:
        if GAPS.get(number, 99.0) <= now < GAPS.get(number, 99.0) + GAP_SECS:
            continue
        stamp = max(0.0, before + 1e-4, now + draws.gauss(0.0, 0.003))
        before = stamp
        if now >= hidden_until and draws.random() < 0.0008:
            hidden_until = now + draws.uniform(0.04, 0.16)
        seen = [x_m + draws.gauss(0.0, 0.002), max(0.0, distance_m + draws.gauss(0.0, 0.003)), abs(speed_m_s + draws.gauss(0.0, 0.004))]
        mocap = [""] * 3 if now < hidden_until else [f"{1000 * value:.1f}" for value in seen]
        glove = max(0.0, force_n + (GLOVE_BIAS_N if number in BIASED else 0.0) + draws.gauss(0.0, 0.15))
        plc = [state, str(parts), str(lost)]
        lines.append(",".join([f"{stamp:.4f}", *mocap, f"{glove:.2f}", *plc]))
    return lines


def recordings(folder):
    """The recordings of the third series."""
    for number, draws in people("third", SERIES["third"][0]):
        rows = []
        visit(Someone(draws), draws, rows)
        text = "\n".join(recorded(number, rows, draws)) + "\n"
        if number == CUT_SHORT:
            text = text[: round(len(text) * CUT_SHARE)]
        (folder / f"visit-{number:02}.csv").write_text(text, encoding="utf-8")


def truth(count, seed):
    """Rates over many people, one visit each of ten, with standard errors over people."""
    shares = {key: [] for key in REQUIREMENTS + MODES}
    for _, draws in people("truth", count, seed):
        someone = Someone(draws)
        seen = [visit(someone, draws) for _ in range(10)]
        for key, rates in shares.items():
            came_up = [v[key] for v in seen if v[key] is not None]
            rates.append((sum(came_up), len(came_up)))
    for key, rates in shares.items():
        hits, tries = (sum(column) for column in zip(*rates))
        if not tries:
            print(f"{key:14} never came up")
            continue
        rate = hits / tries
        spread = math.sqrt(sum((h - rate * t) ** 2 for h, t in rates)) / tries
        print(f"{key:14} {rate:.4f}  +- {spread:.4f}  ({hits} of {tries})")


if __name__ == "__main__":
    what, rest = (sys.argv[1:2] or [""])[0], sys.argv[2:]
    if what == "trials":
        trials(Path(rest[0]) if rest else STUDY / "experiments")
    elif what == "recordings":
        recordings(Path(rest[0]) if rest else STUDY / "recordings")
    elif what == "truth":
        truth(int(rest[0]) if rest else 1000, int(rest[1]) if len(rest) > 1 else SEED)
    else:
        sys.exit(__doc__)

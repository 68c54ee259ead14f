"""A stand-in for reality: trials of the swarm with physics and parameters that no model and no simulation of this study sees.

    python3 reality/trials.py tables --from 1 --sessions 30 --out tables/trials_1     # the tables of 30 sessions of 4 trials each
    python3 reality/trials.py trial 3 2 recording.csv                                 # session 3, trial 2, as a recording
    python3 reality/trials.py walls --from 1 --sessions 30                            # jackets brought, by their distance to a wall

It is declared for what it is: a program, not a robot. The robots run the study's own program (`program/forager.py`). Everything
around it is written apart from the other simulations: wheels that lag, wear and slip; a position that is dead reckoning between
fixes that fail now and then; batteries that sag and die; a lidar and a camera that overlook things for a while; a cup that does not
always seal; people who walk across the room. Floor, people and batteries belong to a session, so trials of one session are alike.
Only the standard library is used; the same session and trial give the same bytes.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from pathlib import Path
from typing import Dict, List, Optional, Tuple

STUDY = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(STUDY / "program"))

from forager import Forager  # noqa: E402

SEED = "cloakroom 20240722"
TRIALS_A_SESSION = 4
ROBOTS = BAGS = 4
DURATION_SECS = 90.0
STEP_SECS, TICK_STEPS = 0.02, 5
WIDTH_M, HALF_M = 4.0, 1.5
BODY_M, BAG_M = 0.125, 0.07
COUNTER_M = 0.7
PROGRAM = {
    "cruise_speed_m_s": 0.4,
    "slow_speed_m_s": 0.15,
    "turn_rate_rad_s": 1.8,
    "body_radius_m": BODY_M,
    "way_half_width_m": 0.25,
    "avoid_m": 0.4,
    "stop_m": 0.15,
    "drop_x_m": 0.45,
    "store_from_x_m": 0.8,
    "shortest_leg_secs": 2.0,
    "longest_leg_secs": 6.0,
    "approach_secs": 8.0,
    "forget_secs": 1.5,
    "back_off_secs": 1.5,
}
ANGLES = [-2.0943951023931953 + 4.1887902047863905 * ray / 32 for ray in range(33)]
# The limits of the requirements (parameters.toml), for the counts.
DELIVERY_SECS, SHARE_SECS, APART_M, WAITING_SECS, CLEARING_SECS = 75.0, 40.0, 0.03, 5.0, 5.0
STANDSTILL_M_S = 0.03
FIRST_SECS, SECOND_SECS = 20.0, 30.0
EVENTS = ("see", "see_each", "grab", "lose", "bring", "slip", "stop")


class Session:
    """What trials of one session have in common."""

    def __init__(self, number: int):
        draws = random.Random(f"{SEED} session {number}")
        self.number = number
        self.slip = draws.uniform(0.02, 0.10)
        self.speed_share = draws.uniform(0.82, 0.98)
        self.walks_each_secs = draws.uniform(15.0, 60.0)
        self.overlooked = draws.uniform(0.1, 0.35)
        self.seals = draws.uniform(0.7, 0.95)
        self.fix_fails = draws.uniform(0.05, 0.25)
        # Batteries that were not full in the morning.
        self.dies_each_secs = draws.choice((3000.0, 6000.0, 12000.0))


class Robot:
    def __init__(self, number: int, session: Session, draws: random.Random):
        strip = 2.6 / ROBOTS
        self.x = draws.uniform(0.95, 1.25)
        self.y = draws.uniform(-1.3 + strip * number + 0.22, -1.3 + strip * (number + 1) - 0.22)
        self.yaw = draws.uniform(-1.5, 1.5)
        self.left = self.right = 0.0
        self.left_worn, self.right_worn = draws.gauss(1.0, 0.02), draws.gauss(1.0, 0.02)
        self.lag_secs = draws.uniform(0.12, 0.3)
        self.believed = [self.x, self.y, self.yaw]
        self.dies_at = draws.expovariate(1.0 / session.dies_each_secs)
        self.dead = False
        self.holds: Optional[int] = None
        self.sealing_since: Optional[float] = None
        self.command = (0.0, 0.0, 0.0)
        self.speed = 0.0
        self.blind_until: Dict[str, float] = {}
        self.sees_until: Dict[str, float] = {}
        self.draws = draws
        self.program = Forager(PROGRAM, ANGLES, random.Random(draws.random()))


class Person:
    """Somebody walks across from one side to the other, and stops before a robot most of the time."""

    def __init__(self, draws: random.Random):
        side = draws.choice((-1.0, 1.0))
        self.x, self.y = draws.uniform(0.6, 3.4), -side * (HALF_M + 0.3)
        self.to_x, self.to_y = draws.uniform(0.6, 3.4), side * (HALF_M + 0.3)
        self.speed = draws.uniform(0.7, 1.3)
        self.careful = draws.random() < 0.9


class Trial:
    def __init__(self, session: Session, number: int):
        self.session = session
        self.draws = random.Random(f"{SEED} session {session.number} trial {number}")
        strip = 2.6 / BAGS
        self.bags = [
            [self.draws.uniform(2.3, 3.75), self.draws.uniform(-1.3 + strip * k + 0.22, -1.3 + strip * (k + 1) - 0.22)]
            for k in range(BAGS)
        ]
        self.robots = [Robot(k, session, random.Random(f"{self.draws.random()} robot {k}")) for k in range(ROBOTS)]
        self.people: List[Person] = []
        self.next_walk = self.draws.expovariate(1.0 / session.walks_each_secs)
        self.rows: List[Tuple[float, List[Dict[str, object]], List[bool]]] = []
        self.events = {name: [0, 0] for name in EVENTS}

    # What there is to be measured.

    def gap(self, robot: Robot) -> float:
        others = (math.hypot(robot.x - o.x, robot.y - o.y) for o in self.robots if o is not robot)
        return min(others) - 2 * BODY_M

    def ranges(self, robot: Robot, now: float) -> List[float]:
        """A scan. A dark thing may be overlooked for half a second."""
        discs = []
        for kind, things, radius in (("r", self.robots, BODY_M), ("p", self.people, 0.2)):
            for index, thing in enumerate(things):
                if thing is robot:
                    continue
                key = f"{kind}{index}"
                if now >= robot.blind_until.get(key, 0.0) and robot.draws.random() < 0.01:
                    robot.blind_until[key] = now + 0.5
                dx, dy = thing.x - robot.x, thing.y - robot.y
                distance = math.hypot(dx, dy)
                if distance < 1.8 and now >= robot.blind_until.get(key, 0.0):
                    discs.append((dx, dy, distance * distance - radius * radius))
        scan = []
        for angle in ANGLES:
            cos, sin = math.cos(robot.yaw + angle), math.sin(robot.yaw + angle)
            best = 1.5
            if cos > 1e-9:
                best = min(best, (WIDTH_M - robot.x) / cos)
            elif cos < -1e-9:
                best = min(best, -robot.x / cos)
            if sin > 1e-9:
                best = min(best, (HALF_M - robot.y) / sin)
            elif sin < -1e-9:
                best = min(best, (-HALF_M - robot.y) / sin)
            for dx, dy, power in discs:
                along = dx * cos + dy * sin
                if along > 0.0:
                    inside = along * along - power
                    if inside >= 0.0:
                        best = min(best, max(0.0, along - math.sqrt(inside)))
            scan.append(best + robot.draws.gauss(0.0, 0.015))
        return scan

    def sights(self, robot: Robot, now: float) -> List[Tuple[float, float]]:
        """The bags that the camera shows. What is overlooked stays overlooked for a second."""
        held = {other.holds for other in self.robots}
        shown = []
        for index, (bag_x, bag_y) in enumerate(self.bags):
            if index in held and robot.holds != index:
                continue
            dx, dy = bag_x - robot.x, bag_y - robot.y
            ahead = dx * math.cos(robot.yaw) + dy * math.sin(robot.yaw)
            left = -dx * math.sin(robot.yaw) + dy * math.cos(robot.yaw)
            if math.hypot(ahead, left) > 0.9 or abs(math.atan2(left, ahead)) > 0.95:
                continue
            key = f"b{index}"
            if now >= robot.sees_until.get(key, 0.0):
                robot.sees_until[key] = now + 1.0
                robot.blind_until[key] = now + 1.0 if robot.draws.random() < self.session.overlooked else 0.0
            if now >= robot.blind_until.get(key, 0.0):
                shown.append((ahead + robot.draws.gauss(0.0, 0.02), left + robot.draws.gauss(0.0, 0.02)))
        return shown

    # What happens.

    def tick(self, now: float) -> None:
        waiting = BAGS - sum(self.at_counter()) - sum(r.holds is not None and not self.in_counter(r.holds) for r in self.robots)
        for robot in self.robots:
            if now >= robot.dies_at and not robot.dead:
                robot.dead, robot.command = True, (0.0, 0.0, 0.0)
                robot.holds = None
                self.events["stop"][0] += 1
            if robot.dead:
                continue
            if robot.draws.random() >= self.session.fix_fails:
                robot.believed = [robot.x + robot.draws.gauss(0, 0.02), robot.y + robot.draws.gauss(0, 0.02),
                                  robot.yaw + robot.draws.gauss(0, 0.03)]
            program = robot.program
            before, brought = program.state, program.brought
            self.expose(before, waiting)
            command = program.tick(now, tuple(robot.believed), self.ranges(robot, now), self.sights(robot, now),
                                   robot.holds is not None)
            robot.command = command
            self.count(before, program.state, program.brought > brought)
            self.cup(robot, now)

    def expose(self, state: str, waiting: int) -> None:
        """One tenth of a second in a state."""
        self.events["stop"][1] += 1
        if state in ("search", "back_off"):
            if waiting > 0:
                self.events["see"][1] += 1
                self.events["see_each"][1] += waiting
        elif state == "approach":
            self.events["grab"][1] += 1
            self.events["lose"][1] += 1
        else:
            self.events["bring"][1] += 1
            self.events["slip"][1] += 1

    def count(self, before: str, after: str, brought: bool) -> None:
        if before != "approach" and after == "approach":
            self.events["see"][0] += 1
            self.events["see_each"][0] += 1
        if before == "approach" and after == "carry":
            self.events["grab"][0] += 1
        if before == "approach" and after in ("search", "back_off"):
            self.events["lose"][0] += 1
        if brought:
            self.events["bring"][0] += 1
        elif before == "carry" and after != "carry":
            self.events["slip"][0] += 1

    def cup(self, robot: Robot, now: float) -> None:
        if robot.command[2] < 0.5:
            robot.holds, robot.sealing_since = None, None
            return
        if robot.holds is not None:
            if robot.draws.random() < 0.0008:
                robot.holds = None
            return
        held = {other.holds for other in self.robots}
        for index, (bag_x, bag_y) in enumerate(self.bags):
            dx, dy = bag_x - robot.x, bag_y - robot.y
            off = math.atan2(dy, dx) - robot.yaw
            near = math.hypot(dx, dy) < BODY_M + BAG_M + 0.03 and abs(math.atan2(math.sin(off), math.cos(off))) < 0.35
            if near and index not in held:
                if robot.sealing_since is None:
                    robot.sealing_since = now
                # A seal that fails is tried again after half a second.
                if now - robot.sealing_since >= 0.5:
                    robot.sealing_since = now
                    if robot.draws.random() < self.session.seals:
                        robot.holds = index
                return
        robot.sealing_since = None

    def drive(self, robot: Robot) -> None:
        speed, turn, _ = robot.command
        sag = self.session.speed_share
        share = STEP_SECS / robot.lag_secs
        left, right = speed - 0.1 * turn, speed + 0.1 * turn
        robot.left += (sag * left - robot.left) * share
        robot.right += (sag * right - robot.right) * share
        grip = 1.0 - self.session.slip * robot.draws.random() * 2.0
        true_left, true_right = robot.left * robot.left_worn * grip, robot.right * robot.right_worn * grip
        along, turned = (true_left + true_right) / 2, (true_right - true_left) / 0.2
        robot.yaw += turned * STEP_SECS
        robot.x += along * math.cos(robot.yaw) * STEP_SECS
        robot.y += along * math.sin(robot.yaw) * STEP_SECS
        # Dead reckoning takes the wheels for new.
        believed = robot.believed
        believed[2] += (robot.right - robot.left) / 0.2 * STEP_SECS
        believed[0] += (robot.left + robot.right) / 2 * math.cos(believed[2]) * STEP_SECS
        believed[1] += (robot.left + robot.right) / 2 * math.sin(believed[2]) * STEP_SECS
        if robot.holds is not None:
            reach = BODY_M + BAG_M + 0.01
            self.bags[robot.holds] = [robot.x + reach * math.cos(robot.yaw), robot.y + reach * math.sin(robot.yaw)]

    def push(self) -> None:
        """Who overlaps is pushed apart; bags are pushed along."""
        robots = self.robots
        for i, a in enumerate(robots):
            for b in robots[i + 1:]:
                dx, dy = b.x - a.x, b.y - a.y
                distance = math.hypot(dx, dy)
                if 0.0 < distance < 2 * BODY_M:
                    push = (2 * BODY_M - distance) / 2 / distance
                    a.x, a.y, b.x, b.y = a.x - dx * push, a.y - dy * push, b.x + dx * push, b.y + dy * push
            for person in self.people:
                dx, dy = a.x - person.x, a.y - person.y
                distance = math.hypot(dx, dy)
                if 0.0 < distance < BODY_M + 0.2:
                    push = (BODY_M + 0.2 - distance) / distance
                    a.x, a.y = a.x + dx * push, a.y + dy * push
            a.x = min(WIDTH_M - BODY_M, max(BODY_M, a.x))
            a.y = min(HALF_M - BODY_M, max(-HALF_M + BODY_M, a.y))
        held = {robot.holds for robot in robots}
        for index, bag in enumerate(self.bags):
            if index not in held:
                for robot in robots:
                    dx, dy = bag[0] - robot.x, bag[1] - robot.y
                    distance = math.hypot(dx, dy)
                    if 0.0 < distance < BODY_M + BAG_M:
                        push = (BODY_M + BAG_M - distance) / distance
                        bag[0], bag[1] = bag[0] + dx * push, bag[1] + dy * push
            bag[0] = min(WIDTH_M - BAG_M, max(BAG_M, bag[0]))
            bag[1] = min(HALF_M - BAG_M, max(-HALF_M + BAG_M, bag[1]))

    def walk(self, now: float) -> None:
        if now >= self.next_walk:
            self.people.append(Person(self.draws))
            self.next_walk = now + self.draws.expovariate(1.0 / self.session.walks_each_secs)
        for person in list(self.people):
            dx, dy = person.to_x - person.x, person.to_y - person.y
            left = math.hypot(dx, dy)
            if left < 0.1:
                self.people.remove(person)
                continue
            ahead = person.x + 0.5 * dx / left, person.y + 0.5 * dy / left
            blocked = any(math.hypot(r.x - ahead[0], r.y - ahead[1]) < 0.4 for r in self.robots if not r.dead)
            if person.careful and blocked:
                # Who waits goes round after a moment.
                person.x += 0.3 * STEP_SECS * -dy / left
                person.y += 0.3 * STEP_SECS * dx / left
                continue
            person.x += person.speed * STEP_SECS * dx / left
            person.y += person.speed * STEP_SECS * dy / left

    def in_counter(self, bag: int) -> bool:
        return self.bags[bag][0] < COUNTER_M

    def at_counter(self) -> List[bool]:
        return [self.in_counter(bag) for bag in range(BAGS)]

    def run(self) -> "Trial":
        for step in range(round(DURATION_SECS / STEP_SECS) + 1):
            now = step * STEP_SECS
            self.walk(now)
            if step % TICK_STEPS == 0:
                self.tick(now)
                self.record(now)
            places = [(robot.x, robot.y) for robot in self.robots]
            for robot in self.robots:
                if not robot.dead:
                    self.drive(robot)
            self.push()
            for robot, (x, y) in zip(self.robots, places):
                robot.speed = math.hypot(robot.x - x, robot.y - y) / STEP_SECS
        return self

    def record(self, now: float) -> None:
        robots = [
            {"x": r.x, "y": r.y, "speed": r.speed, "gap": self.gap(r), "in": r.x < COUNTER_M, "holds": r.holds is not None,
             "state": r.program.state if not r.dead else "dead"}
            for r in self.robots
        ]
        self.rows.append((now, robots, self.at_counter()))

    # What comes of it.

    def verdicts(self) -> Dict[str, Optional[bool]]:
        """Each requirement and each way to fail: passed or occurred; None where it never came up."""
        brought = [sum(bags) for _, _, bags in self.rows]
        times = [now for now, _, _ in self.rows]
        first = lambda count, limit: any(b >= count and t <= limit + 1e-9 for b, t in zip(brought, times))
        waits = [any(r["holds"] and r["speed"] < STANDSTILL_M_S for r in robots) for _, robots, _ in self.rows]
        crowds = [sum(r["in"] for r in robots) >= 3 for _, robots, _ in self.rows]
        gaps = [min(r["gap"] for r in robots) for _, robots, _ in self.rows]
        return {
            "brought": first(BAGS, DELIVERY_SECS),
            "share": first(2, SHARE_SECS),
            "apart": all(gap >= APART_M for gap in gaps),
            "waiting": ended(waits, times, WAITING_SECS),
            "crowd": ended(crowds, times, CLEARING_SECS),
            "slow_first": not first(1, FIRST_SECS),
            "slow_second": not first(2, SECOND_SECS),
            "touch": any(gap <= 0.0005 for gap in gaps),
        }

    def recording(self) -> str:
        names = []
        for k in range(1, ROBOTS + 1):
            names += [f"/truth/r{k}.x [m]", f"/truth/r{k}.y [m]", f"/truth/r{k}.speed [m/s]",
                      f"/truth/r{k}.distance_to.robots [m]", f"/truth/r{k}.in.counter", f"/sensor/grip{k}.holding",
                      f"/controller/p{k}.state"]
        names += [f"/truth/bag{k}.in.counter" for k in range(1, BAGS + 1)]
        lines = [",".join(["time_secs", *names])]
        for now, robots, bags in self.rows:
            cells = [f"{now:.1f}"]
            for r in robots:
                cells += [f"{r['x']:.3f}", f"{r['y']:.3f}", f"{r['speed']:.4f}", f"{r['gap']:.4f}",
                          "true" if r["in"] else "false",
                          "true" if r["holds"] else "false", r["state"]]
            cells += ["true" if bag else "false" for bag in bags]
            lines.append(",".join(cells))
        return "\n".join(lines) + "\n"


def ended(holds: List[bool], times: List[float], limit: float) -> Optional[bool]:
    """Whether what begins always ends within the limit; None if it never begins. What still waits at the end is left open."""
    began: Optional[float] = None
    seen = False
    for held, now in zip(holds, times):
        if held and began is None:
            began, seen = now, True
        if not held:
            if began is not None and now - began > limit + 1e-9:
                return False
            began = None
        elif began is not None and now - began > limit + 1e-9:
            return False
    return True if seen else None


def tables(first: int, sessions: int, out: Path) -> None:
    requirements = {name: [0, 0] for name in ("brought", "share", "apart", "waiting", "crowd")}
    modes = {name: [0, 0] for name in ("slow_first", "slow_second", "touch")}
    events = {name: [0, 0] for name in EVENTS}
    cohort = []
    for number in range(first, first + sessions):
        session = Session(number)
        row = {name: 0 for name in ("brought", "share", "apart", "slow_first", "slow_second", "touch")}
        for trial_number in range(1, TRIALS_A_SESSION + 1):
            trial = Trial(session, trial_number).run()
            verdicts = trial.verdicts()
            for name, counts in list(requirements.items()) + list(modes.items()):
                if verdicts[name] is not None:
                    counts[0] += bool(verdicts[name])
                    counts[1] += 1
            for name in row:
                row[name] += bool(verdicts[name])
            for name in EVENTS:
                events[name][0] += trial.events[name][0]
                events[name][1] += trial.events[name][1]
        cohort.append([number, TRIALS_A_SESSION, *row.values()])
        print(f"session {number}: {row}", file=sys.stderr)
    head = f"# Made by `python3 reality/trials.py tables --from {first} --sessions {sessions} --out {out}`: a program, not a robot.\n"
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "requirements.csv", "w", encoding="utf-8") as file:
        file.write(head + "requirement,covered,passed,failed\n")
        for name, (passed, covered) in requirements.items():
            file.write(f"{name},{covered},{passed},{covered - passed}\n")
    with open(out / "failure_modes.csv", "w", encoding="utf-8") as file:
        file.write(head + "mode,occurrences,opportunities\n")
        for name, (count, of) in modes.items():
            file.write(f"{name},{count},{of}\n")
    with open(out / "changes.csv", "w", encoding="utf-8") as file:
        file.write(head + "mode,occurrences,opportunities\n")
        for name, (count, of) in events.items():
            file.write(f"{name},{count},{of}\n")
    with open(out / "sessions.csv", "w", encoding="utf-8") as file:
        file.write(head + "session,attempts,brought,share,apart,slow_first,slow_second,touch\n")
        for row in cohort:
            file.write(",".join(str(cell) for cell in row) + "\n")


def walls(first: int, sessions: int) -> None:
    """How many jackets are at the counter in time, by how near to a wall they stood at first."""
    near, far = [0, 0], [0, 0]
    for number in range(first, first + sessions):
        for trial_number in range(1, TRIALS_A_SESSION + 1):
            trial = Trial(Session(number), trial_number)
            clear = [min(WIDTH_M - x, HALF_M - abs(y)) for x, y in trial.bags]
            trial.run()
            at_last = [bags for now, _, bags in trial.rows if now <= DELIVERY_SECS + 1e-9][-1]
            for clearance, brought in zip(clear, at_last):
                counts = near if clearance < PROGRAM["avoid_m"] else far
                counts[0] += brought
                counts[1] += 1
    print(f"nearer than {PROGRAM['avoid_m']} m: {near[0]} of {near[1]}; others: {far[0]} of {far[1]}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Trials of the stand-in for reality.")
    commands = parser.add_subparsers(dest="command", required=True)
    counted = commands.add_parser("tables")
    counted.add_argument("--from", dest="first", type=int, required=True)
    counted.add_argument("--sessions", type=int, required=True)
    counted.add_argument("--out", type=Path, required=True)
    by_wall = commands.add_parser("walls")
    by_wall.add_argument("--from", dest="first", type=int, required=True)
    by_wall.add_argument("--sessions", type=int, required=True)
    one = commands.add_parser("trial")
    one.add_argument("session", type=int)
    one.add_argument("trial", type=int)
    one.add_argument("recording", type=Path)
    asked = parser.parse_args()
    if asked.command == "tables":
        tables(asked.first, asked.sessions, asked.out)
    elif asked.command == "walls":
        walls(asked.first, asked.sessions)
    else:
        asked.recording.write_text(Trial(Session(asked.session), asked.trial).run().recording(), encoding="utf-8")


if __name__ == "__main__":
    main()

"""The swarm at low fidelity: discs that turn and go, without wheels, contact forces or noise. One step is a tenth of a second.

    python3 lowfi/swarm.py                                    # episodes as they are asked for (the ledger's `command`)
    python3 lowfi/swarm.py count STIMULUS RUNS SEED OUT       # counts the changes of state of RUNS runs into the table OUT
    python3 lowfi/swarm.py many 1000 60                       # 1000 robots for 60 s, and how much processor time it took

A robot searches on legs of random direction, approaches the bag that it notices, takes it, and carries it straight to the counter.
Before what is in its way it stops and turns to one side. What it can do is set by the stimulus.
"""

from __future__ import annotations

import json
import math
import random
import sys
import time
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent.parent / "integrations/common"))

from corroborate_rig import Episode, Recording, main  # noqa: E402

STEP_SECS = 0.1
DURATION_SECS = 90.0
BODY_M, BAG_M = 0.125, 0.07
COUNTER_M, DROP_M, STORE_M = 0.7, 0.45, 0.8
VIEW_RAD = 1.0
EVENTS = ("see", "see_each", "grab", "lose", "bring", "slip", "stop", "grab_wall", "lose_wall", "by_wall")
CELL_M = 1.0


class Robot:
    __slots__ = ("x", "y", "yaw", "state", "heading", "leg", "bag", "since", "speed", "aside", "aside_until")

    def __init__(self, x: float, y: float, yaw: float):
        self.x, self.y, self.yaw, self.heading = x, y, yaw, yaw
        self.state, self.leg, self.bag, self.since, self.speed = "search", 0.0, -1, 0.0, 0.0
        self.aside, self.aside_until = 0.0, -1.0


class Swarm:
    """As many robots as bags in a room 4 m deep, with 0.75 m of the counter (x = 0) for each: 3 m for the usual four."""

    def __init__(self, settings: Dict[str, float], draws: random.Random, robots: int = 4):
        self.s, self.draws, self.length, self.half = settings, draws, 4.0, 0.375 * robots
        strip = (2 * self.half - 0.4) / robots
        low = -self.half + 0.2
        self.robots: List[Robot] = []
        self.bags: List[Optional[Tuple[float, float]]] = []
        for k in range(robots):
            y = low + strip * k + 0.22, low + strip * (k + 1) - 0.22
            spot, bag = (draws.uniform(0.95, 1.25), draws.uniform(*y)), (draws.uniform(2.3, 3.75), draws.uniform(*y))
            self.robots.append(Robot(*spot, draws.uniform(-1.5, 1.5)))
            self.bags.append(bag)
        self.brought = [False] * robots
        self.free = set(range(robots))
        self.events = {name: [0, 0] for name in EVENTS}
        self.events["by_wall"] = [sum(self.by_wall(bag) for bag in range(robots)), robots]
        self.now = 0.0

    def cells(self, things) -> Dict[Tuple[int, int], list]:
        grid: Dict[Tuple[int, int], list] = {}
        for thing, x, y in things:
            grid.setdefault((int(x / CELL_M), int(y / CELL_M + 10000)), []).append((thing, x, y))
        return grid

    @staticmethod
    def around(grid, x: float, y: float):
        i, j = int(x / CELL_M), int(y / CELL_M + 10000)
        for a in (i - 1, i, i + 1):
            for b in (j - 1, j, j + 1):
                yield from grid.get((a, b), ())

    def step(self) -> None:
        """A tenth of a second for all, one after the other."""
        robots = self.cells((r, r.x, r.y) for r in self.robots)
        bags = self.cells((k, *self.bags[k]) for k in self.free)
        waiting = len(self.free)
        for robot in self.robots:
            if robot.state != "dead":
                before = robot.state
                wall = robot.bag >= 0 and self.by_wall(robot.bag)
                self.expose(before, waiting, wall)
                self.decide(robot, bags)
                self.count(before, robot.state, wall)
                self.go(robot, [r for r, _, _ in self.around(robots, robot.x, robot.y) if r is not robot])
            else:
                robot.speed = 0.0
        self.now += STEP_SECS

    def by_wall(self, bag: int) -> bool:
        """Whether a bag stands so near to a wall that robots shy away from it."""
        x, y = self.bags[bag]
        return min(self.length - x, self.half - abs(y)) < self.s["shy_m"]

    def expose(self, state: str, waiting: int, wall: bool) -> None:
        events = self.events
        events["stop"][1] += 1
        if state in ("search", "back_off"):
            if waiting > 0:
                events["see"][1] += 1
                events["see_each"][1] += waiting
        elif state == "approach":
            events["grab_wall" if wall else "grab"][1] += 1
            events["lose_wall" if wall else "lose"][1] += 1
        else:
            events["bring"][1] += 1
            events["slip"][1] += 1

    def count(self, before: str, after: str, wall: bool) -> None:
        if before == after:
            return
        events = self.events
        if after == "dead":
            events["stop"][0] += 1
        elif after == "approach":
            events["see"][0] += 1
            events["see_each"][0] += 1
        elif before == "approach":
            events[("grab" if after == "carry" else "lose") + ("_wall" if wall else "")][0] += 1
        elif before == "carry":
            events["bring" if after == "back_off" else "slip"][0] += 1

    def decide(self, robot: Robot, bags) -> None:
        s, draws, now = self.s, self.draws, self.now
        if s["stop_rate_hz"] and draws.random() < s["stop_rate_hz"] * STEP_SECS:
            self.release(robot)
            robot.state = "dead"
            return
        if robot.state == "search":
            bag = self.noticed(robot, bags)
            if bag is not None:
                robot.state, robot.bag, robot.since = "approach", bag, now
            elif now >= robot.leg:
                robot.heading = draws.uniform(-math.pi, math.pi)
                robot.leg = now + draws.uniform(2.0, 6.0)
        elif robot.state == "approach":
            bag = robot.bag
            gives_up = s["shy_rate_hz"] if bag in self.free and self.by_wall(bag) else s["lose_rate_hz"]
            if bag not in self.free or draws.random() < gives_up * STEP_SECS:
                robot.state, robot.since, robot.bag = "back_off", now, -1
                return
            x, y = self.bags[bag]
            robot.heading = math.atan2(y - robot.y, x - robot.x)
            if math.hypot(x - robot.x, y - robot.y) < BODY_M + BAG_M + 0.02:
                if draws.random() < STEP_SECS / max(STEP_SECS, s["take_secs"]):
                    self.free.discard(bag)
                    robot.state, robot.since = "carry", now
        elif robot.state == "carry":
            robot.heading = math.pi
            if draws.random() < s["slip_rate_hz"] * STEP_SECS:
                self.release(robot)
                robot.state = "search"
            elif robot.x < DROP_M:
                self.brought[robot.bag] = True
                self.bags[robot.bag] = (robot.x - BODY_M - BAG_M, robot.y)
                robot.state, robot.since, robot.bag = "back_off", now, -1
        elif now - robot.since >= s["back_off_secs"]:
            robot.state, robot.heading, robot.leg = "search", draws.uniform(-1.0, 1.0), now + 4.0

    def release(self, robot: Robot) -> None:
        """A bag that is lost stays where it is."""
        if robot.state == "carry":
            self.bags[robot.bag] = (max(STORE_M, robot.x - BODY_M - BAG_M), robot.y)
            self.free.add(robot.bag)
        robot.bag = -1

    def noticed(self, robot: Robot, bags) -> Optional[int]:
        sight = self.s["sight_m"]
        best, nearest = None, sight
        for k, x, y in self.around(bags, robot.x, robot.y):
            if k not in self.free:
                continue
            dx, dy = x - robot.x, y - robot.y
            distance = math.hypot(dx, dy)
            if distance < nearest:
                off = math.atan2(dy, dx) - robot.yaw
                if abs(math.atan2(math.sin(off), math.cos(off))) < VIEW_RAD:
                    best, nearest = k, distance
        if best is not None and self.draws.random() >= self.s["notice_rate_hz"] * STEP_SECS:
            return None
        return best

    def go(self, robot: Robot, others: Sequence[Robot]) -> None:
        s, draws = self.s, self.draws
        # Who searches keeps off the counter.
        if robot.state == "search" and robot.x < STORE_M and math.cos(robot.heading) < 0.3:
            robot.heading = draws.uniform(-1.0, 1.0)
        backwards = robot.state == "back_off"
        heading = robot.aside if self.now < robot.aside_until else robot.heading
        off = math.atan2(math.sin(heading - robot.yaw), math.cos(heading - robot.yaw))
        most = s["turn_rate_rad_s"] * STEP_SECS
        if backwards:
            speed = -0.15
        else:
            robot.yaw += max(-most, min(most, off))
            speed = s["speed_m_s"] * max(0.0, math.cos(off))
        cos, sin = math.cos(robot.yaw), math.sin(robot.yaw)
        x, y = robot.x + speed * STEP_SECS * cos, robot.y + speed * STEP_SECS * sin
        blocked = not (BODY_M < x < self.length - BODY_M and abs(y) < self.half - BODY_M)
        for other in others:
            dx, dy = other.x - x, other.y - y
            distance = math.hypot(dx, dy) - 2 * BODY_M
            if distance < s["keep_m"] and (dx * cos + dy * sin) * speed > 0.0:
                blocked = True
        if blocked:
            speed = 0.0
            if not backwards:
                # To one side for a second, or on another leg.
                side = 1.0 if draws.random() < 0.5 else -1.0
                robot.aside, robot.aside_until = robot.yaw + side * draws.uniform(0.5, 2.0), self.now + 1.0
                if robot.state == "search":
                    robot.heading = robot.aside
                    robot.leg = self.now + draws.uniform(2.0, 6.0)
        else:
            robot.x, robot.y = x, y
        robot.speed = abs(speed)

    def gaps(self) -> List[float]:
        """The gap between the surfaces of each robot and its nearest neighbour, for small swarms."""
        rs = self.robots
        return [min(3.0, min(math.hypot(a.x - b.x, a.y - b.y) for b in rs if b is not a) - 2 * BODY_M) for a in rs]


def run(episode: Episode) -> Recording:
    swarm = Swarm({key: episode.number(key) for key in KEYS}, episode.draws("swarm"))
    signals: Dict[str, str] = {}
    for k in range(1, 5):
        signals[f"/truth/r{k}.distance_to.robots"] = "m"
        signals[f"/truth/r{k}.in.counter"] = ""
        signals[f"/truth/r{k}.speed"] = "m/s"
        signals[f"/sensor/grip{k}.holding"] = ""
    for k in range(1, 5):
        signals[f"/truth/bag{k}.in.counter"] = ""
    recording = Recording(signals)
    for step in range(round(DURATION_SECS / STEP_SECS) + 1):
        cells: list = []
        for robot, gap in zip(swarm.robots, swarm.gaps()):
            cells += [gap, robot.x < COUNTER_M, robot.speed, robot.state == "carry"]
        recording.row(round(step * STEP_SECS, 1), *cells, *swarm.brought)
        swarm.step()
    return recording


KEYS = ("speed_m_s", "turn_rate_rad_s", "sight_m", "notice_rate_hz", "take_secs", "lose_rate_hz", "slip_rate_hz", "stop_rate_hz",
        "back_off_secs", "keep_m", "shy_m", "shy_rate_hz")


def settings_of(stimulus: str) -> Dict[str, float]:
    """The settings of a stimulus as the ledger names it: lines `key = number`, without distributions."""
    values = {}
    for line in Path(stimulus).read_text(encoding="utf-8").splitlines():
        key, _, value = line.partition("=")
        key = key.strip().strip('"')
        if key in KEYS:
            values[key] = float(value.split("#")[0])
    return {key: values[key] for key in KEYS}


def count(stimulus: str, runs: int, seed: str, out: str) -> None:
    """Changes of state, each against the tenths of a second in which it could have come."""
    settings, total = settings_of(stimulus), {name: [0, 0] for name in EVENTS}
    for number in range(runs):
        swarm = Swarm(settings, random.Random(f"{seed} {number}"))
        while swarm.now < DURATION_SECS and not all(swarm.brought):
            swarm.step()
        for name, counts in swarm.events.items():
            total[name][0] += counts[0]
            total[name][1] += counts[1]
    lines = [f"# Made by `python3 lowfi/swarm.py count {stimulus} {runs} {seed} {out}`.", "mode,occurrences,opportunities"]
    # A swarm that does not shy away from walls has no jackets by a wall.
    lines += [f"{name},{count},{of}" for name, (count, of) in total.items() if settings["shy_m"] or not name.endswith("wall")]
    Path(out).write_text("\n".join(lines) + "\n", encoding="utf-8")


def many(robots: int, secs: float) -> None:
    """As many robots, each with a jacket and its share of the room."""
    settings = settings_of(str(HERE / "first.toml"))
    swarm = Swarm(settings, random.Random("many"), robots)
    began = time.process_time()
    while swarm.now < secs:
        swarm.step()
    took = time.process_time() - began
    print(json.dumps({"robots": robots, "simulated_secs": secs, "processor_secs": round(took, 1),
                      "times_real_time": round(secs / took, 1), "jackets_brought": sum(swarm.brought)}))


if __name__ == "__main__":
    words = sys.argv[1:]
    if words[:1] == ["count"] and len(words) == 5:
        count(words[1], int(words[2]), words[3], words[4])
    elif words[:1] == ["many"] and len(words) == 3:
        many(int(words[1]), float(words[2]))
    else:
        main(run, words)

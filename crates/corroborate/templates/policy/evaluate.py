"""Runs the policy for an episode and records it.

Usage: evaluate.py STIMULUS SEED RECORDING

The world is a gripper over a table, a point mass in two dimensions. Replace it by your own environment: reset it with the
seed, ask the policy in each step, write a row of what requirements speak of. All that is random comes from the seed.
"""

import json
import math
import random
import sys

from policy import Policy

STEP_S = 0.05
LONGEST_S = 8.0


class Table:
    """The environment: where the gripper and the part are, and what the policy is told of that."""

    def __init__(self, settings, seed):
        self.draws = random.Random(seed)
        self.noise = settings["camera.noise_m"]
        self.hand = [0.0, 0.0]
        self.velocity = [0.0, 0.0]
        angle, far = self.draws.uniform(-math.pi, math.pi), self.draws.uniform(0.15, 0.4)
        self.part = [far * math.cos(angle), far * math.sin(angle)]
        # The camera is off by this much in the whole episode, and by `noise` in each picture.
        self.offset = [self.draws.gauss(0, settings["camera.offset_m"]) for _ in range(2)]
        self.drag = self.draws.uniform(0.1, 0.4)

    def observe(self):
        """What the policy gets."""
        seen = zip(self.part, self.hand, self.offset)
        to_part = [part - hand + offset + self.draws.gauss(0, self.noise) for part, hand, offset in seen]
        return {"to_part_m": to_part, "velocity_m_s": list(self.velocity)}

    def step(self, action):
        """Moves on by a step with this acceleration."""
        for axis, wanted in enumerate(action):
            self.velocity[axis] += (wanted - self.drag * self.velocity[axis]) * STEP_S
            self.hand[axis] += self.velocity[axis] * STEP_S

    def row(self):
        """Distance to the part, distance from the table's middle, speed."""
        return math.dist(self.hand, self.part), math.hypot(*self.hand), math.hypot(*self.velocity)


def main():
    stimulus, seed, recording = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    with open(stimulus, encoding="utf-8") as file:
        table = Table(json.load(file)["settings"], seed)
    policy = Policy()
    policy.reset(seed)
    with open(recording, "w", encoding="utf-8") as file:
        file.write("time_s,running,distance_m,off_middle_m,speed_m_s\n")
        for step in range(round(LONGEST_S / STEP_S)):
            distance, off_middle, speed = table.row()
            file.write(f"{step * STEP_S:.2f},1,{distance:.5f},{off_middle:.5f},{speed:.5f}\n")
            table.step(policy.act(table.observe()))


main()

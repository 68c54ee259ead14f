"""A simulator of a few lines, which knows nothing of Corroborate: a cart brakes before an obstacle.

Usage: simulate.py STIMULUS SEED RECORDING

STIMULUS is a JSON file with the settings of stimulus.toml, RECORDING the table to write. The brake acts after a random
delay, and at half its strength on a wet floor. Replace this file by your own simulator, or by a script that starts it.
"""

import json
import random
import sys

STEP_MS = 10
LONGEST_MS = 10_000


def simulate(settings, draws):
    """The rows of an episode. All that is random comes from `draws`, so that a seed always gives the same rows."""
    speed = settings["cart.speed_cm_per_s"] * draws.uniform(0.8, 1.2)
    wet = draws.random() < 0.1
    braking = settings["cart.braking_cm_per_s2"] * (0.5 if wet else 1.0)
    brakes_ms = 1000 + draws.uniform(0, 300)
    gap = settings["cart.gap_cm"]
    stopped_at = None
    for now_ms in range(0, LONGEST_MS, STEP_MS):
        yield now_ms, gap, speed, int(now_ms >= 1000)
        if stopped_at is None and (speed == 0 or gap <= 0):
            stopped_at = now_ms
        # Go on a little, so that the end of the recording is not the moment of standstill.
        if stopped_at is not None and now_ms >= stopped_at + 500:
            return
        if gap <= 0:
            speed = 0.0
        elif now_ms >= brakes_ms:
            speed = max(0.0, speed - braking * STEP_MS / 1000)
        gap -= speed * STEP_MS / 1000


def main():
    stimulus, seed, recording = sys.argv[1:]
    with open(stimulus, encoding="utf-8") as file:
        settings = json.load(file)["settings"]
    with open(recording, "w", encoding="utf-8") as file:
        file.write("time_ms,gap_cm,speed_cm_per_s,sees_obstacle\n")
        for now_ms, gap, speed, sees in simulate(settings, random.Random(int(seed))):
            file.write(f"{now_ms},{gap:.3f},{speed:.3f},{sees}\n")


main()

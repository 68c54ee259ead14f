"""A simulator that knows nothing of Corroborate: a cart brakes in front of an obstacle.

Usage: simulate.py STIMULUS SEED RECORDING

STIMULUS is a JSON file with what is done and set (here `cart.speed_cm_per_s` and
`cart.braking_cm_per_s2`), RECORDING the table to write: centimetres and milliseconds, as the cart's
makers have them. The brake acts after a random delay; on a wet floor it acts less.
"""

import json
import random
import sys

STEP_MS = 10
LONGEST_MS = 20_000


def simulate(settings: dict, draws: random.Random) -> list[str]:
    speed = settings["cart.speed_cm_per_s"] * draws.uniform(0.8, 1.2)
    braking = settings["cart.braking_cm_per_s2"] * (0.5 if draws.random() < 0.1 else 1.0)
    seen_ms = 1000
    acts_ms = seen_ms + 20 * round(draws.uniform(0.0, 15.0))
    gap = 400.0
    rows = []
    for now_ms in range(0, LONGEST_MS + 1, STEP_MS):
        rows.append(f"{now_ms},{gap!r},{speed!r},{int(now_ms >= seen_ms)}")
        if speed == 0.0 or gap <= 0.0:
            break
        if now_ms >= acts_ms:
            speed = max(0.0, speed - braking * STEP_MS / 1000)
        gap -= speed * STEP_MS / 1000
    return rows


def main() -> None:
    stimulus, seed, recording = sys.argv[1:]
    with open(stimulus, encoding="utf-8") as file:
        settings = json.load(file)["settings"]
    rows = simulate(settings, random.Random(int(seed)))
    with open(recording, "w", encoding="utf-8") as file:
        file.write("time_ms,gap_cm,speed_cm_per_s,obstacle_seen\n")
        file.writelines(row + "\n" for row in rows)


main()

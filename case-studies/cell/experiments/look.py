"""What the recordings of the third series show beside verdicts: `python3 experiments/look.py`.

For each recording: where the person's middle was when the program first slowed down, how often the person came to the table,
how long the stays were, and the glove's reading before anybody was near (its bias).
"""

import csv
from pathlib import Path

TABLE_MM, WARNING_MM = 1450.0, 2220.0


def looked_at(path):
    """The figures of one recording."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if None not in row.values()]
    noticed, visits, inside, stays, since, idle = None, 0, False, [], 0.0, []
    for row in rows:
        if not row["person_x_mm"]:
            continue
        x, now = float(row["person_x_mm"]), float(row["time_s"])
        if noticed is None and row["state"] != "work":
            noticed = x
        if x > WARNING_MM and visits == 0 and row["glove_n"]:
            idle.append(float(row["glove_n"]))
        if (x < TABLE_MM) != inside:
            inside = not inside
            visits += inside
            if inside:
                since = now
            else:
                stays.append(now - since)
    return noticed, visits, stays, sum(idle) / max(1, len(idle))


if __name__ == "__main__":
    for path in sorted((Path(__file__).resolve().parent.parent / "recordings").glob("*.csv")):
        noticed, visits, stays, bias = looked_at(path)
        where = "never" if noticed is None else f"{noticed:5.0f} mm"
        print(f"{path.name}: slows down at {where}, visits {visits}, stays {', '.join(f'{s:.1f} s' for s in stays)}, glove {bias:.1f} N")

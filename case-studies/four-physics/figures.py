"""The figures of a run of this study: `figures.py RESULTS [--hold]`.

Prints what the README's tables show: counts by requirement, and of the recordings where the crate came to rest and how hard it was
pressed, episode by episode against MuJoCo's own Python (the same seeds, so the same friction and place of the crate). With
`--hold` it ends with code 1 unless the README's conclusions hold for these episodes, however many they are.
"""

from __future__ import annotations

import csv
import json
import statistics
import sys
from pathlib import Path
from typing import Dict, List

MATCHED, DESCRIBED = ("S1", "P1", "D1", "M1"), ("S2", "P2", "D2", "M2")
REQUIREMENTS = ("mark", "hand", "gentle")


def counts(results: Path, entry: str) -> Dict[str, Dict[str, int]]:
    """How often each requirement was satisfied, of how many episodes."""
    evidence = json.loads((results / "evidence" / f"{entry}.json").read_text(encoding="utf-8"))
    found = {}
    for finding in evidence["content"]["findings"]:
        measure = finding["measure"]
        found[finding["subject"]["id"]] = {"count": measure["count"], "trials": measure["trials"]}
    return found


def rests(results: Path, entry: str) -> List[Dict[str, float]]:
    """Of each episode of a command where the crate is at the end, and the greatest force; own scenes leave no tables."""
    shown = []
    for path in sorted((results / "episodes" / entry).glob("episode-*.csv")):
        with open(path, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        force = max(float(row["/truth/pusher.contact.crate.normal_force [N]"]) for row in rows)
        shown.append({"first_m": float(rows[0]["/truth/crate.x [m]"]), "x_m": float(rows[-1]["/truth/crate.x [m]"]), "force_n": force})
    return shown


def shares(of: Dict[str, Dict[str, Dict[str, int]]], entry: str, requirement: str) -> float:
    """The share of episodes in which it was satisfied."""
    return of[entry][requirement]["count"] / of[entry][requirement]["trials"]


def show(of: Dict[str, Dict[str, Dict[str, int]]], recorded: Dict[str, List[Dict[str, float]]]) -> None:
    """Both tables, as the README has them."""
    print("| entry | " + " | ".join(REQUIREMENTS) + " |\n|---|---|---|---|")
    for entry in (*MATCHED, *DESCRIBED):
        cells = [f"{of[entry][it]['count']} of {of[entry][it]['trials']}" for it in REQUIREMENTS]
        print(f"| {entry} | " + " | ".join(cells) + " |")
    print("\n| entry | rest, mean | from M of the same episode, mean and greatest | greatest force, median |\n|---|---|---|---|")
    for entry, episodes in recorded.items():
        mean = statistics.mean(it["x_m"] for it in episodes)
        apart = [1000 * (it["x_m"] - other["x_m"]) for it, other in zip(episodes, recorded["M" + entry[1]])]
        force = statistics.median(it["force_n"] for it in episodes)
        print(f"| {entry} | {mean:.3f} m | {statistics.mean(apart):+.0f} mm, {max(apart, key=abs):+.0f} mm | {force:.0f} N |")


def broken(of: Dict[str, Dict[str, Dict[str, int]]], recorded: Dict[str, List[Dict[str, float]]]) -> List[str]:
    """The conclusions of the README that these episodes do not bear out."""
    x = {entry: [it["x_m"] for it in episodes] for entry, episodes in recorded.items()}
    gap = {entry: max(abs(a - b) for a, b in zip(x[entry], x["M1"])) for entry in ("P1", "D1")}
    starts = [[it["first_m"] for it in episodes] for episodes in recorded.values()]
    said = {
        "all physics have the same stimuli": all(
            abs(a - b) < 1e-9 for other in starts for a, b in zip(other, starts[0])
        ),
        "matched friction: rests differ by at most 20 mm": max(gap.values()) <= 0.02,
        "matched friction: the mark is reached alike, within 2 episodes of 10": max(
            abs(shares(of, entry, "mark") - shares(of, "S1", "mark")) for entry in MATCHED
        ) <= 0.2,
        "matched friction: the hand is never touched": all(shares(of, entry, "hand") == 1 for entry in MATCHED),
        "as described: in each episode the crate goes farthest in PyBullet": all(
            p > max(d, m) for p, d, m in zip(x["P2"], x["D2"], x["M2"])
        ),
        "as described: on average it goes farther in Drake than in MuJoCo": statistics.mean(x["D2"]) > statistics.mean(x["M2"]),
        "as described: PyBullet always touches the hand, no other does": [
            shares(of, entry, "hand") for entry in DESCRIBED
        ] == [1, 0, 1, 1],
        "hard contacts press hard, soft ones do not": all(
            (shares(of, entry, "gentle") == 1) == (entry[0] in "SM") for entry in (*MATCHED, *DESCRIBED)
        ),
        "hard contacts press hard nearly always": all(
            shares(of, entry, "gentle") < 0.3 for entry in (*MATCHED, *DESCRIBED) if entry[0] in "PD"
        ),
        "the tool's own scene is the same in both conditions": of["S1"] == of["S2"],
    }
    return [what for what, holds in said.items() if not holds]


def main() -> int:
    """Prints, and holds to what was concluded if asked to."""
    results = Path(sys.argv[1])
    of = {entry: counts(results, entry) for entry in (*MATCHED, *DESCRIBED)}
    recorded = {entry: rests(results, entry) for entry in (*MATCHED, *DESCRIBED) if entry[0] != "S"}
    show(of, recorded)
    wrong = broken(of, recorded) if "--hold" in sys.argv[2:] else []
    for what in wrong:
        print(f"does not hold: {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

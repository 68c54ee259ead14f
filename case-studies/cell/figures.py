"""How near each piece of evidence comes to the truth of the stand-in.

    python3 case-studies/cell/figures.py [RESULTS]

prints, from the results of `corroborate run` and from `reality/truth.txt`, the rate of each requirement and way to fail in each
piece of evidence, and how far they lie from the truth on average, in points.
"""

import json
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SUBJECTS = ("separation", "transient", "quasi_static", "work", "unnoticed", "struck", "lost")
# What the formal models have a word for, so that all of a step are averaged over the same.
AVERAGED = ("separation", "work", "unnoticed", "struck", "lost")


def truth():
    """By subject the rate and its standard error."""
    words = (line.split() for line in (HERE / "reality/truth.txt").read_text(encoding="utf-8").splitlines())
    return {word[0]: (float(word[1]), float(word[3])) for word in words}


def rates(evidence):
    """By subject the rate and how it is written."""
    found = {}
    for finding in evidence["findings"]:
        measure, subject = finding["measure"], finding["subject"]["id"]
        if measure["kind"] == "counts":
            found[subject] = measure["count"] / measure["trials"], f"{measure['count']}/{measure['trials']}"
        elif measure["kind"] == "probability" and measure["answer"]["guarantee"]["kind"] != "schedulers":
            found[subject] = measure["answer"]["value"], f"{measure['answer']['value']:.4f}"
    return found


def main(results):
    """The table."""
    true = truth()
    print(f"{'':12}" + "".join(f"{subject:>14}" for subject in SUBJECTS) + "   off by")
    print(f"{'truth':12}" + "".join(f"{true[subject][0]:14.4f}" for subject in SUBJECTS))
    for evidence in json.loads((results / "study.json").read_text(encoding="utf-8"))["evidence"]:
        found = rates(evidence)
        cells = "".join(f"{found[subject][1] if subject in found else '-':>14}" for subject in SUBJECTS)
        off = [abs(found[subject][0] - true[subject][0]) for subject in AVERAGED if subject in found]
        mean = f"{100 * sum(off) / len(off):6.1f}" if len(off) == len(AVERAGED) else "     -"
        print(f"{evidence['id']:12}{cells}   {mean}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "results")

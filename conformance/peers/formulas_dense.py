#!/usr/bin/env python3
"""Judge random formulas on random signals beside RTAMT, in dense time; fail where the two differ.

Usage: .ci/run peers        (installs the peers into .tools/peers, then calls this)
       formulas_dense.py JUDGE [CASES [SEED]]

JUDGE is the example `judge` of the crate temporal.

The robustness at the first time must be the same number, and the verdict its sign. What RTAMT means otherwise than we do
(as observed of version 0.4.10) is written out in our terms, so that both judge the same formula:

* For RTAMT the last value of a signal holds for ever. Ours ends with the last sample; it is given the same values once more,
  later than any window can reach, and windows of the future without an end are given one that is later
  than any change.
* Its `p until q` demands p at the time of q, too; ours demands it only before. It is given to us as `p until (p and q)`, and
  since likewise.
* Its equivalence has another robustness; it is given as `(p and q) or (not p and not q)`.
* It has no rise and fall in dense time.
* Where its since is minus infinity at the beginning, it leaves that part out, and what is computed from it is wrong there. So
  within since, windows of the past begin at 0, where nothing is infinite.
"""

import math
import random
import subprocess
import sys

import rtamt

ATOMS = ["p", "q", "r"]
# Later than any change: signals end by 40 s, and four nested windows of the past reach 60 s further.
FOR_EVER_SECS = 200
# Later than four nested windows of the future, each of them FOR_EVER_SECS and its lower end long.
END_SECS = 2_000


def window(source, past, begins_now):
    """A window as both write it; there may be none."""
    if source.random() < 0.3:
        return "" if past else f"[0, {FOR_EVER_SECS} s]", ""
    low = 0 if begins_now else source.choice([0, 0, 0, 1, 2, 5])
    high = low + source.choice([1, 2, 4, 9])
    return f"[{low}, {high} s]", f"[{low}:{high}]"


def formula(source, depth, in_since=False):
    """A random formula: our text, and RTAMT's."""
    if depth == 0 or source.random() < 0.1:
        atom = source.choice(ATOMS)
        return atom, f"({atom} >= 0)"
    kind = source.choice(["not", "one", "one", "one", "logic", "until", "since"])
    below = in_since or kind == "since"
    ours, theirs = formula(source, depth - 1, below)
    if kind == "not":
        return f"not ({ours})", f"not ({theirs})"
    if kind == "one":
        name = source.choice(["always", "eventually", "once", "historically"])
        past = name in ("once", "historically")
        our_window, their_window = window(source, past, in_since and past)
        return f"{name}{our_window} ({ours})", f"{name}{their_window} ({theirs})"
    our_second, their_second = formula(source, depth - 1, below)
    if kind == "logic":
        name, sign = source.choice([("and", "and"), ("or", "or"), ("=>", "->"), ("<=>", None)])
        if sign is None:
            both = f"(({theirs}) and ({their_second})) or ((not ({theirs})) and (not ({their_second})))"
            return f"({ours}) <=> ({our_second})", both
        return f"({ours}) {name} ({our_second})", f"({theirs}) {sign} ({their_second})"
    our_window, their_window = window(source, kind == "since", in_since and kind == "since")
    both = f"({ours}) {kind}{our_window} (({ours}) and ({our_second}))"
    return both, f"({theirs}) {kind}{their_window} ({their_second})"


def signals(source):
    """Times and values; each signal changes at all of the times, or keeps its value."""
    times = [0]
    for _ in range(source.choice([1, 2, 4, 8, 12])):
        times.append(times[-1] + source.choice([0.5, 1, 1, 2, 3]))
    values = {}
    for atom in ATOMS:
        column = []
        for _ in times:
            column.append(source.choice([-3.5, -3, -2.5, -2, -1, 1, 1.5, 2, 3]) if not column or source.random() < 0.7 else column[-1])
        values[atom] = column
    return times, values


def ours(all_cases):
    """Our verdicts and robustness."""
    lines = []
    for (text, _), (times, values) in all_cases:
        rows = [*zip(times, *values.values())]
        rows.append((END_SECS, *rows[-1][1:]))
        lines.append("\t".join(["dense", "finite", ",".join(values), text, *(",".join(map(str, row)) for row in rows)]))
    command = [sys.argv[1]]
    done = subprocess.run(command, input="\n".join(lines), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
    return [line.split("\t") for line in done.stdout.splitlines()]


def theirs(text, times, values):
    """RTAMT's robustness at the first time."""
    specification = rtamt.StlDenseTimeSpecification()
    for atom in ATOMS:
        specification.declare_var(atom, "float")
    specification.spec = text
    specification.parse()
    return specification.evaluate(*([atom, [list(pair) for pair in zip(times, column)]] for atom, column in values.items()))[0][1]


def main():
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 3_000
    source = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    all_cases = [(formula(source, source.choice([1, 2, 3, 4])), signals(source)) for _ in range(count)]
    passed, failed = 0, 0
    for ((text, their_text), (times, values)), (verdict, low, high) in zip(all_cases, ours(all_cases), strict=True):
        wanted = theirs(their_text, times, values)
        sign = "Satisfied" if wanted > 0 else "Violated"
        if float(low) == float(high) == wanted and verdict in (sign, "NotCovered") and not math.isnan(wanted):
            passed += 1
            continue
        failed += 1
        print(f"DIFFERS {text} at {times} of {values}: RTAMT {wanted}, ours {verdict}, {low} to {high}")
    print(f"formulas in dense time beside RTAMT: {passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()

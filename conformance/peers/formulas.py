#!/usr/bin/env python3
"""Judge random formulas on random traces beside RTAMT, in discrete time; fail where the two differ.

Usage: .ci/run peers        (installs the peers into .tools/peers, then calls this)
       formulas.py JUDGE [CASES [SEED]]

JUDGE is the example `judge` of the crate temporal.

The robustness at the first sample must be the same number, and the verdict its sign. What RTAMT means otherwise than we
do (as observed of version 0.4.10) is written out in its own terms, so that both judge the same formula:

* The trace is all there is: a window that is cut off by its end, or empty, makes "eventually" false and "always" true. This
  is our ending "finite".
* It needs at least two samples.
* Its `next` at the last sample, and its `prev` at the first one, are true (plus infinity); ours are false. So `next p` is
  given to it as `not next not p`.
* Its equivalence has the robustness -|p - q|, which is not that of `(p and q) or (not p and not q)`; it is given as this.
* Its `unless[a:b]` is `always[0:b] p or p until[a:b] q`, which for a > 0 is not the dual of release. Ours is compared where a = 0.
"""

import math
import random
import subprocess
import sys

import rtamt

ATOMS = ["p", "q", "r"]


def window(random):
    """A window as both write it; there may be none."""
    if random.random() < 0.3:
        return "", ""
    low = random.choice([0, 0, 0, 1, 2, 5])
    high = low + random.choice([0, 1, 2, 4, 9])
    unit = random.choice(["samples", "s"])
    return f"[{low}, {high} {unit}]", f"[{low}:{high}]"


def formula(random, depth):
    """A random formula: our text, and RTAMT's."""
    if depth == 0 or random.random() < 0.1:
        atom = random.choice(ATOMS)
        return atom, f"({atom} >= 0)"
    ours, theirs = formula(random, depth - 1)
    kind = random.choice(["not", "next", "previous", "rise", "fall", "one", "one", "one", "logic", "logic", "two", "two"])
    if kind == "not":
        return f"not ({ours})", f"not ({theirs})"
    if kind in ("next", "previous"):
        return f"{kind} ({ours})", f"not ({kind[:4]} (not ({theirs})))"
    if kind in ("rise", "fall"):
        return f"{kind}({ours})", f"{kind}({theirs})"
    our_window, their_window = window(random)
    if kind == "one":
        name = random.choice(["always", "eventually", "once", "historically"])
        return f"{name}{our_window} ({ours})", f"{name}{their_window} ({theirs})"
    our_second, their_second = formula(random, depth - 1)
    if kind == "logic":
        name, sign = random.choice([("and", "and"), ("or", "or"), ("=>", "->"), ("<=>", None)])
        if sign is None:
            both = f"(({theirs}) and ({their_second})) or ((not ({theirs})) and (not ({their_second})))"
            return f"({ours}) <=> ({our_second})", both
        return f"({ours}) {name} ({our_second})", f"({theirs}) {sign} ({their_second})"
    names = [("until", "until"), ("since", "since")]
    if their_window.startswith("[0"):
        names.append(("weak_until", "unless"))
    name, sign = random.choice(names)
    return f"({ours}) {name}{our_window} ({our_second})", f"({theirs}) {sign}{their_window} ({their_second})"


def cases(count, seed):
    """Random formulas and traces; values are small whole numbers other than 0, so that many are equal."""
    source = random.Random(seed)
    for _ in range(count):
        length = source.choice([2, 3, 5, 8, 13, 30])
        values = {atom: [source.choice([-3, -2, -1, 1, 2, 3]) + source.choice([0, 0.5]) for _ in range(length)] for atom in ATOMS}
        # Wrong sides of zero must not come from the halves.
        yield formula(source, source.choice([1, 2, 3, 4])), {
            atom: [value - 1.0 if value == 0 else value for value in column] for atom, column in values.items()
        }


def ours(all_cases):
    """Our verdicts and robustness."""
    lines = []
    for (text, _), values in all_cases:
        samples = (",".join(map(str, sample)) for sample in zip(*values.values()))
        samples = [f"{time},{sample}" for time, sample in enumerate(samples)]
        lines.append("\t".join(["discrete", "finite", ",".join(values), text, *samples]))
    command = [sys.argv[1]]
    done = subprocess.run(command, input="\n".join(lines), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
    return [line.split("\t") for line in done.stdout.splitlines()]


def theirs(text, values):
    """RTAMT's robustness at the first sample."""
    specification = rtamt.StlDiscreteTimeSpecification()
    for atom in ATOMS:
        specification.declare_var(atom, "float")
    specification.spec = text
    specification.parse()
    times = list(range(len(values[ATOMS[0]])))
    return specification.evaluate({"time": times, **values})[0][1]


def main():
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 3_000
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    all_cases = list(cases(count, seed))
    passed, failed = 0, 0
    for ((text, their_text), values), (verdict, low, high) in zip(all_cases, ours(all_cases), strict=True):
        wanted = theirs(their_text, values)
        # Ours also says whether what the formula waits for ever came.
        verdicts = ["Satisfied", "NotCovered"] if wanted > 0 else ["Violated"]
        if float(low) == float(high) == wanted and verdict in verdicts and not math.isnan(wanted):
            passed += 1
            continue
        failed += 1
        print(f"DIFFERS {text} on {values}: RTAMT {wanted}, ours {verdict}, {low} to {high}")
    print(f"formulas beside RTAMT: {passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()

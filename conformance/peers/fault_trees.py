#!/usr/bin/env python3
"""Compare the values of random static fault trees with Storm's, and with the enumeration of all truth assignments.

Usage: .ci/run peers        (installs the peers into .tools/peers, then calls this)
       fault_trees.py PROGRAM [CASES [SEED]]

PROGRAM is the example `values` of the crate fault-tree. With failure rates, Storm's probability that the top event has
failed by the mission time must lie within our bounds, up to Storm's precision. With probabilities, which Storm does not
take for basic events, our exact value must be the rational number that enumeration gives, and the number of minimal cut
sets that of the minimal assignments.
"""

import random
import subprocess
import sys
import tempfile
from fractions import Fraction
from itertools import product
from pathlib import Path

import stormpy
import stormpy.dft

TIME = 2
# Storm's default precision of a transient analysis.
PRECISION = 1e-6


def tree(draw, kinds):
    """The number of events, and gates over events and earlier gates; the last one is the top event."""
    events = draw.randint(2, 7)
    gates = []
    for number in range(draw.randint(1, 6)):
        known = list(range(events + number))
        chosen = draw.sample(known, min(len(known), draw.randint(2, 4)))
        if number and events + number - 1 not in chosen:
            chosen.append(events + number - 1)
        kind = draw.choice(kinds)
        if kind == "not":
            chosen = chosen[-1:]
        if kind == "xor":
            chosen = chosen[-2:]
        if kind == "of":
            kind = f"{draw.randint(1, len(chosen))}of{len(chosen)}"
        gates.append((kind, chosen))
    return events, gates


def text(events, gates, data):
    """A tree in Galileo's format, without events that no gate uses."""
    name = lambda it: f'"e{it}"' if it < events else f'"g{it - events}"'
    lines = [f'toplevel "g{len(gates) - 1}";']
    lines += [" ".join([name(events + index), kind, *map(name, chosen)]) + ";" for index, (kind, chosen) in enumerate(gates)]
    used = {it for _, chosen in gates for it in chosen}
    lines += [f'"e{event}" {data[event]};' for event in range(events) if event in used]
    return "\n".join(lines) + "\n"


def occurs(assignment, gates):
    """Whether the top event occurs, by the definition of each gate."""
    values = list(assignment)
    for kind, chosen in gates:
        count = sum(values[it] for it in chosen)
        least = kind.split("of")[0]
        values.append({
            "and": lambda: count == len(chosen), "or": lambda: count > 0, "not": lambda: count == 0, "nor": lambda: count == 0,
            "nand": lambda: count < len(chosen), "xor": lambda: count == 1,
        }.get(kind, lambda: count >= int(least))())
    return values[-1]


def enumerated(events, gates, probabilities):
    """The exact probability, and the number of minimal assignments in which the top event occurs."""
    solutions = [a for a in product((False, True), repeat=events) if occurs(a, gates)]
    total = Fraction(0)
    for assignment in solutions:
        weight = Fraction(1)
        for value, probability in zip(assignment, probabilities):
            weight *= probability if value else 1 - probability
        total += weight
    sets = [frozenset(i for i, value in enumerate(a) if value) for a in solutions]
    return total, sum(not any(other < it for other in sets) for it in sets)


def storm(path):
    """Storm's probability that the top event has failed by the mission time."""
    model = stormpy.dft.load_dft_galileo_file(str(path))
    formulas = stormpy.parse_properties(f'P=? [ F<={TIME} "failed" ]')
    return stormpy.dft.analyze_dft(model, formulas)[0]


def ours(program, paths):
    """Bounds, exact value and number of cut sets of each file."""
    called = subprocess.run([program, str(TIME), *map(str, paths)], capture_output=True, text=True, check=True)
    return {line.split("\t")[0]: line.split("\t")[1:] for line in called.stdout.splitlines()}


def main():
    program, cases, seed = sys.argv[1], int((sys.argv + ["", "200"])[2] or 200), int((sys.argv + ["", "", "1"])[3] or 1)
    draw = random.Random(seed)
    folder = Path(tempfile.mkdtemp())
    with_rates, with_probabilities = {}, {}
    for case in range(cases):
        events, gates = tree(draw, ["and", "or", "of"])
        path = folder / f"rates{case}.dft"
        path.write_text(text(events, gates, [f"lambda={draw.randint(1, 900) / 1000}" for _ in range(events)]))
        with_rates[str(path)] = storm(path)
        events, gates = tree(draw, ["and", "or", "of", "not", "nor", "nand", "xor"])
        numbers = [Fraction(draw.randint(1, 999), 1000) for _ in range(events)]
        path = folder / f"probabilities{case}.dft"
        path.write_text(text(events, gates, [f"prob={float(it)}" for it in numbers]))
        with_probabilities[str(path)] = enumerated(events, gates, numbers)
    found = ours(program, [*with_rates, *with_probabilities])
    wrong = 0
    for path, value in with_rates.items():
        lower, upper = map(float, found[path][:2])
        if not lower - PRECISION <= value <= upper + PRECISION:
            wrong += 1
            print(f"Storm {value}, here {lower} to {upper}:\n{Path(path).read_text()}")
    for path, (value, sets) in with_probabilities.items():
        if Fraction(found[path][2]) != value or int(found[path][3]) != sets:
            wrong += 1
            print(f"enumeration {value} and {sets} sets, here {found[path]}:\n{Path(path).read_text()}")
    print(f"fault trees: {cases} with rates beside Storm, {cases} with probabilities beside enumeration, {wrong} differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

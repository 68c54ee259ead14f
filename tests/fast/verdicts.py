"""Compares two campaigns of the same seeds, episode by episode: every verdict of every monitor.

    corroborate simulate STUDY E4 -n 500 --keep none --out full
    corroborate simulate COPY_WITH_FAST_PHYSICS E4 -n 500 --keep none --out fast
    python3 tests/fast/verdicts.py full/episodes.parquet fast/episodes.parquet

A monitor's verdict in one episode is compared as "violated or not" and as "covered or not". For each
it prints how many episodes show it in either campaign, in how many only one of them does, the exact p
of McNemar's test (twice the lower tail of a binomial of the discordant episodes and 1/2, at most 1)
and that p after Holm's step-down over all comparisons with a discordant episode. Then come the largest
differences of the monitors' robustness. Ends with 1 if a corrected p is below 0.05. Needs pyarrow.
"""

import math
import sys

import pyarrow.parquet


def table(path):
    """The columns of a campaign, by episode's seed."""
    columns = pyarrow.parquet.read_table(path).to_pydict()
    seeds = columns["seed"]
    return {seed: {name: column[row] for name, column in columns.items()} for row, seed in enumerate(seeds)}


def mcnemar(first, second):
    number, fewer = first + second, min(first, second)
    tail = sum(math.comb(number, hits) for hits in range(fewer + 1)) / 2**number
    return min(1.0, 2 * tail)


def holm(values):
    """Step-down p values, in the order given."""
    order = sorted(range(len(values)), key=values.__getitem__)
    corrected, most = [0.0] * len(values), 0.0
    for rank, index in enumerate(order):
        most = max(most, min(1.0, (len(values) - rank) * values[index]))
        corrected[index] = most
    return corrected


def comparisons(pairs, monitors):
    """What is counted: (monitor, what, in the first, in the second, only first, only second)."""
    for monitor in monitors:
        for what, wanted in (("violated", ("violated",)), ("not covered", ("not-covered",))):
            shown = [[side[f"{monitor}.verdict"] in wanted for side in pair] for pair in pairs]
            if any(map(any, shown)):
                counts = [sum(one) for one in zip(*shown)]
                only = [sum(a and not b for a, b in shown), sum(b and not a for a, b in shown)]
                yield monitor, what, counts, only


def main(first, second):
    tables = [table(path) for path in (first, second)]
    seeds = [seed for seed in tables[0] if seed in tables[1]]
    pairs = [[side[seed] for side in tables] for seed in seeds]
    monitors = [name[: -len(".verdict")] for name in pairs[0][0] if name.endswith(".verdict")]
    rows = list(comparisons(pairs, monitors))
    tested = [mcnemar(*only) for *_, only in rows if any(only)]
    corrected = iter(holm(tested))
    plain = iter(tested)
    print(f"{len(pairs)} pairs of episodes, {len(monitors)} monitors")
    print(f"{'':<36}{'first':>7}{'second':>7}{'only 1st':>9}{'only 2nd':>9}{'p':>8}{'Holm':>8}")
    worst = 1.0
    for monitor, what, counts, only in rows:
        p, after = (next(plain), next(corrected)) if any(only) else (1.0, 1.0)
        worst = min(worst, after)
        name = f"{monitor} {what}"
        print(f"{name:<36}{counts[0]:>7}{counts[1]:>7}{only[0]:>9}{only[1]:>9}{p:>8.3f}{after:>8.3f}")
    differ = sum(any(a[f"{it}.verdict"] != b[f"{it}.verdict"] for it in monitors) for a, b in pairs)
    print(f"{differ} episodes differ in some verdict; smallest corrected p {worst:.3f}")
    for monitor in monitors:
        values = [[side[f"{monitor}.robustness_low"] for side in pair] for pair in pairs]
        finite = [abs(a - b) for a, b in values if a is not None and b is not None and math.isfinite(a - b)]
        if any(finite):
            finite.sort()
            middle, most = finite[len(finite) // 2], finite[-1]
            print(f"robustness of {monitor}: differs by {middle:.2e} in the median, {most:.2e} at most")
    return int(worst < 0.05)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))

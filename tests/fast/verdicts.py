"""Compares two explorations of the same seeds, episode by episode: every verdict of every monitor.

Evidence is always of the full physics, so the fast one runs in searches only: here explorations of the bench's own tests as
they are, whose files differ in `physics` (`tests/fast/plan` prints one).

    tests/fast/plan E4 full > full.toml; corroborate explore STUDY $PWD/full.toml --plain -n 1000 --out full
    tests/fast/plan E4 fast > fast.toml; corroborate explore STUDY $PWD/fast.toml --plain -n 1000 --out fast
    python3 tests/fast/verdicts.py full fast

Each side is such a table of episodes, or a folder in which all are read. A monitor's verdict in one episode is compared
as "violated or not" and as "covered or not". For each it prints how many episodes show it in either campaign, in how many only one
of them does, and

* the exact p of McNemar's test (twice the lower tail of a binomial of the discordant episodes and 1/2,
  at most 1) and that p after Holm's step-down over all comparisons with a discordant episode: is there
  a difference beyond chance?
* the 90 % interval of the difference of the rates, second minus first, in points, by Tango's score
  ("Equivalence test and confidence interval for the difference in proportions for the paired-sample
  design", Statistics in Medicine 17, 1998): are the rates the same within MARGIN points? Where it is
  inside, two one-sided tests at 5 % say so.

Ends with 1 if a corrected p is below 0.05 or an interval reaches beyond the margin; with `--most N`,
where there are too few episodes for either, if more than N differ in some verdict or none are paired.
Needs pyarrow.
"""

import math
import pathlib
import sys

import pyarrow.parquet

MARGIN = 0.02
Z90 = 1.6448536269514722


def table(path):
    """The columns of a campaign, by episode's seed."""
    path, rows = pathlib.Path(path), {}
    for file in sorted(path.rglob("episodes*.parquet")) if path.is_dir() else [path]:
        for row in pyarrow.parquet.read_table(file).to_pylist():
            rows[row["seed"]] = row
    return rows


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


def score(first, second, number, difference):
    """Tango's statistic for the hypothesis that the second rate exceeds the first by `difference`."""
    b = (2 * number - second + first) * difference - first - second
    c = -first * difference * (1 - difference)
    rare = (math.sqrt(max(b * b - 8 * number * c, 0.0)) - b) / (4 * number)
    variance = number * (2 * rare + difference * (1 - difference))
    away = second - first - number * difference
    return away / math.sqrt(variance) if variance > 0 else math.copysign(math.inf, away) if away else 0.0


def interval(first, second, number):
    """Where the statistic is within +-Z90; it falls as the difference grows."""

    def root(level):
        low, high = -1.0, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if score(first, second, number, middle) > level else (low, middle)
        return (low + high) / 2

    return root(Z90), root(-Z90)


def comparisons(pairs, monitors):
    """What is counted: (monitor, what, in the first and the second, only in the first and the second)."""
    for monitor in monitors:
        for what, column, wanted in (("violated", "violated", True), ("not covered", "triggered", False)):
            shown = [[side[f"{monitor}.{column}"] is wanted for side in pair] for pair in pairs]
            if any(map(any, shown)):
                counts = [sum(one) for one in zip(*shown)]
                only = [sum(a and not b for a, b in shown), sum(b and not a for a, b in shown)]
                yield monitor, what, counts, only


def main(first, second, most=None):
    tables = [table(path) for path in (first, second)]
    pairs = [[side[seed] for side in tables] for seed in tables[0] if seed in tables[1]]
    if not pairs:
        print(f"{first} and {second} have no episode of the same seed")
        return 1
    monitors = [name[: -len(".violated")] for name in pairs[0][0] if name.endswith(".violated")]
    rows = list(comparisons(pairs, monitors))
    tested = [mcnemar(*only) for *_, only in rows if any(only)]
    corrected, plain = iter(holm(tested)), iter(tested)
    print(f"{len(pairs)} pairs of episodes, {len(monitors)} monitors; 90 % intervals of second minus first in points")
    print(f"{'':<36}{'first':>7}{'second':>7}{'only 1st':>9}{'only 2nd':>9}{'p':>8}{'Holm':>8}   90 %")
    worst, widest = 1.0, 0.0
    for monitor, what, counts, only in rows:
        p, after = (next(plain), next(corrected)) if any(only) else (1.0, 1.0)
        low, high = interval(*only, len(pairs))
        worst, widest = min(worst, after), max(widest, -low, high)
        name = f"{monitor} {what}"
        print(
            f"{name:<36}{counts[0]:>7}{counts[1]:>7}{only[0]:>9}{only[1]:>9}{p:>8.3f}{after:>8.3f}"
            f"   {100 * low:+.2f} to {100 * high:+.2f}"
        )
    columns = [f"{monitor}.{what}" for monitor in monitors for what in ("violated", "triggered")]
    differ = sum(any(a[it] != b[it] for it in columns) for a, b in pairs)
    print(
        f"{differ} episodes differ in some verdict; smallest corrected p {worst:.3f}; "
        f"every rate is the same within {100 * widest:.2f} points"
    )
    return int(worst < 0.05 or widest > MARGIN if most is None else differ > most)


if __name__ == "__main__":
    match sys.argv[1:]:
        case [first, second]:
            sys.exit(main(first, second))
        case [first, second, "--most", most] if most.isdecimal():
            sys.exit(main(first, second, int(most)))
        case _:
            sys.exit(__doc__)

"""Statistics of counted trials, for those who would otherwise use a test for something else than it is for.

Counts are pairs ``(successes, trials)``. Every result says in its fields what was asked and what was found; rates are between
0 and 1. All functions raise :class:`corroborate.Problem` for counts and settings that make no sense; counts go up to 2^53, beyond
which a computed number does not tell one from the next.

=====================================  =========================================================
question                               answered by
=====================================  =========================================================
What do s of n say of a rate?          :func:`rate`
Is a rate at least, at most so much?   :func:`test_rate`
Do two rates differ, by how much?      :func:`difference`
Do two rates agree within a margin?    :func:`equivalence` (not a large p-value of a difference)
Trials of the same person or session?  :func:`clustered_rate`, :func:`clustering`
May I look while trials go on?         :func:`confidence_sequence`, :class:`RunningRate`, :func:`decide`
I added trials and ask again?          :func:`continued_rate`
The same scenarios before and after?   :func:`paired`
How many trials does it take?          :func:`trials_per_arm`, :func:`power`
Many tests at once?                    :func:`holm`
Do several rates agree?                :func:`heterogeneity`
=====================================  =========================================================
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from . import _checked, _engine
from ._problem import Problem, WrongArgument

__all__ = [
    "ClusteredRate",
    "Clustering",
    "Counts",
    "Difference",
    "Equivalence",
    "Heterogeneity",
    "Paired",
    "Rate",
    "RateTest",
    "RunningRate",
    "clustered_rate",
    "clustering",
    "clusters_of",
    "confidence_sequence",
    "continued_rate",
    "decide",
    "difference",
    "equivalence",
    "heterogeneity",
    "holm",
    "paired",
    "power",
    "rate",
    "test_rate",
    "trials_per_arm",
]

Counts = tuple[int, int]
"""Successes and trials: ``(88, 100)``."""

_stats = _engine.stats

IntervalMethod = Literal["wilson", "agresti-coull", "clopper-pearson", "jeffreys"]


@dataclass(frozen=True, slots=True)
class Rate:
    """A rate and its interval."""

    successes: int
    trials: int
    low: float
    """Lower end of the interval."""
    high: float
    """Upper end of the interval."""
    confidence: float
    """The level of the interval."""
    method: str
    """How the interval was formed."""

    @property
    def estimate(self) -> float:
        """The share of successes; NaN without trials."""
        return self.successes / self.trials if self.trials else float("nan")

    def __str__(self) -> str:
        interval = f"{self.confidence * 100:g} % CI {self.low * 100:.1f} to {self.high * 100:.1f} %"
        return f"{self.successes}/{self.trials}, {interval} ({self.method})"


@dataclass(frozen=True, slots=True)
class RateTest:
    """One-sided and two-sided exact binomial tests of a rate against a threshold."""

    threshold: float
    p_below: float
    """p-value against "the rate is at least the threshold": small if the rate is shown to be below it."""
    p_above: float
    """p-value against "the rate is at most the threshold": small if the rate is shown to be above it."""
    p_two_sided: float
    """p-value against "the rate is the threshold"."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The difference of two rates, first minus second."""

    estimate: float
    low: float
    """Lower end of the interval (Newcombe's, of Wilson's intervals)."""
    high: float
    """Upper end of the interval."""
    p_value: float
    """Against "the rates are equal", two-sided, by Boschloo's exact test (Fisher's beyond 4000 trials in all). Its statistic is
    Fisher's *two-sided* p-value: a table counts as at least as extreme if that is not larger, whichever side it lies on; the
    p-value is the largest probability of such tables at any common rate, so that it is never above Fisher's. SciPy's
    ``boschloo_exact`` orders tables by Fisher's *one-sided* p-value and doubles the smaller side's result: it need not agree, and
    is mostly larger. The test is another procedure than the interval: near the level one may speak where the other does not."""
    confidence: float


@dataclass(frozen=True, slots=True)
class Equivalence:
    """Whether two rates agree within a margin."""

    margin: float
    p_value: float
    """Against "the rates differ by the margin or more": small if agreement is shown."""
    method: str

    def shown(self, alpha: float = 0.05) -> bool:
        """Whether agreement is shown at the significance level ``alpha``. Not shown is not the contrary."""
        return self.p_value <= _checked.number(alpha, "alpha")


@dataclass(frozen=True, slots=True)
class ClusteredRate:
    """A rate of trials that are alike within clusters (persons, sessions, batches)."""

    successes: int
    trials: int
    clusters: int
    """Clusters that have trials."""
    low: float
    high: float
    confidence: float
    method: str
    """``profile`` (likelihood of the beta-binomial model), ``one-each`` (nothing tells how alike trials are, so each cluster
    counts once) or ``independent`` (one cluster, or one trial in each)."""
    effective_successes: float
    effective_trials: float
    """The number of independent trials that say as much."""

    @property
    def estimate(self) -> float:
        """The share of successes."""
        return self.successes / self.trials


@dataclass(frozen=True, slots=True)
class Clustering:
    """How alike the trials of a cluster are."""

    intraclass_correlation: float
    """By analysis of variance; may be negative."""
    design_effect: float
    """The variance of the rate relative to that of independent trials, at least 1."""
    effective_size: float
    """The number of independent trials that say as much."""
    f_statistic: float
    p_value: float
    """Against "no difference between clusters"."""


@dataclass(frozen=True, slots=True)
class Paired:
    """Matched pairs of trials: the same scenario with both systems."""

    pairs: int
    only_first: int
    """Pairs in which only the first succeeded."""
    only_second: int
    difference: float
    """Rate of the second minus rate of the first."""
    low: float
    """Lower end of the interval of the difference: Tango's score interval, made to reach 0 where the exact test (``p_value``) does not
    reject "nothing differs". Tango's alone excludes 0 where no exact test can: of 4 pairs that all change one way ``p_value`` is
    0.125. So an interval without 0 always goes with a ``p_value`` below ``1 - confidence``, and it may be wider than other programs'."""
    high: float
    p_value: float
    """Against "nothing differs", two-sided and exact (McNemar)."""
    confidence: float


@dataclass(frozen=True, slots=True)
class Heterogeneity:
    """Whether several rates are one, and what they are together."""

    q: float
    """Cochran's Q of the log odds, half a success and half a failure having been added to *every* sample, also where no cell is 0:
    so a rate of 0 or 1 has finite log odds, which are less biased in small samples, and one more trial never makes a jump. Programs
    that add to samples with a zero alone give slightly other figures."""
    degrees: int
    p_value: float
    """Against "all rates are equal"."""
    i_squared: float
    """The share of the variation that is beyond chance, 0 to 1."""
    tau_squared: float
    """The variance of the true log odds between samples."""
    pooled: float
    """The mean rate with random effects."""
    low: float
    high: float
    confidence: float


def rate(
    successes: int, trials: int, *, confidence: float = 0.95, method: IntervalMethod = "wilson"
) -> Rate:
    """The interval of a rate, two-sided. ``clopper-pearson`` never covers less than its level.

    >>> print(rate(88, 100))
    88/100, 95 % CI 80.2 to 93.0 % (wilson)
    """
    successes, trials, confidence = _trials(successes, trials, confidence)
    low, high = _stats.interval((successes, trials), confidence, _checked.text(method, "method", "a name", "give \"wilson\""))
    return Rate(successes, trials, low, high, confidence, method)


def test_rate(successes: int, trials: int, *, threshold: float) -> RateTest:
    """Whether a rate is below, above, or other than a threshold.

    >>> round(test_rate(88, 100, threshold=0.95).p_below, 4)
    0.0043
    """
    successes, trials, threshold = _trials(successes, trials, threshold, "threshold")
    return RateTest(threshold, *_stats.rate_tests((successes, trials), threshold))


# Not a test for pytest.
test_rate.__test__ = False  # type: ignore[attr-defined]


def difference(first: Counts, second: Counts, *, confidence: float = 0.95) -> Difference:
    """The difference of two rates of independent samples, first minus second.

    A large p-value does not show that the rates agree: that is :func:`equivalence`. The p-value is Boschloo's, with Fisher's two-sided
    p-value for its statistic (:attr:`Difference.p_value`). Work grows with the root of the trials: seconds at 10^15.

    >>> found = difference((80, 100), (88, 100))
    >>> round(found.estimate, 2), round(found.p_value, 3)
    (-0.08, 0.138)
    """
    first, second = _checked.counts(first, "first"), _checked.counts(second, "second")
    confidence = _checked.number(confidence, "confidence")
    estimate, (low, high), p_value = _stats.difference(first, second, confidence)
    return Difference(estimate, low, high, p_value, confidence)


def equivalence(
    first: Counts,
    second: Counts,
    *,
    margin: float,
    method: Literal["exact", "score", "tost"] = "exact",
) -> Equivalence:
    """Whether two rates differ by less than ``margin``.

    ``exact`` errs at most at its level, whatever the true rates are, and is given up to a hundred million trials of each; ``score`` and
    ``tost`` (Agresti-Caffo) are approximate.

    >>> found = equivalence((960, 1000), (955, 1000), margin=0.05)
    >>> found.shown(alpha=0.05)
    True
    >>> equivalence((18, 20), (18, 20), margin=0.05).shown()
    False
    """
    first, second = _checked.counts(first, "first"), _checked.counts(second, "second")
    margin, name = _checked.number(margin, "margin"), _checked.text(method, "method", "a name", "give \"exact\"")
    return Equivalence(margin, _stats.equivalence(first, second, margin, name), method)


def _trials(successes: Any, trials: Any, share: Any, name: str = "confidence") -> tuple[int, int, float]:
    """Two counts and a number."""
    return _checked.trials(successes, "successes"), _checked.trials(trials, "trials"), _checked.number(share, name)


def _pairs(counts: Any, name: str) -> list[Counts]:
    """Counts of several samples."""
    pairs = _checked.several(counts, name, "pairs (successes, trials)", "write [(9, 10), (10, 10)]")
    return [_checked.counts(pair, f"{name}[{place}]") for place, pair in enumerate(pairs)]


def _two(pair: Any, name: str, wanted: str) -> tuple[Any, Any]:
    """Two entries, one for each arm."""
    found = _checked.several(pair, name, wanted, f"give two {wanted}, one for each arm")
    if len(found) != 2:
        message = f"{name} has {len(found)} entries, and there are two arms"
        raise Problem("wrong-argument", message, remedy=f"give two {wanted}, one for each arm")
    return found[0], found[1]


def _rates(pair: Any) -> tuple[float, float]:
    """The true rates of two arms."""
    first, second = _two(pair, "rates", "rates")
    return _checked.number(first, "rates[0]"), _checked.number(second, "rates[1]")


def _margin(margin: Any) -> float | None:
    return None if margin is None else _checked.number(margin, "margin")


def _succeeded(outcome: Any) -> bool:
    """An outcome that is true or false, 1 or 0: what is missing or something else counts neither way."""
    try:
        is_truth = not isinstance(outcome, (str, bytes)) and bool(outcome == 0 or outcome == 1)
    except (TypeError, ValueError):
        is_truth = False
    if not is_truth:
        message = f"an outcome is `{_checked.shown(outcome)}`, which is neither true nor false"
        raise Problem("bad-statistics", message, remedy="leave out trials without an outcome, and write True or False, or 1 or 0")
    return bool(outcome)


def clusters_of(outcomes: Iterable[Any], groups: Iterable[Any]) -> list[Counts]:
    """Counts of each cluster, from one outcome (true or false) and one label for each trial, in the order in which the labels
    come first. Lists, arrays and columns of data frames do.

    >>> clusters_of([True, False, True], ["ann", "ann", "bob"])
    [(1, 2), (1, 1)]
    """
    found: dict[Any, list[int]] = {}
    outcomes = _checked.several(outcomes, "outcomes", "outcomes", "give one outcome for each trial")
    groups = _checked.several(groups, "groups", "labels", "give one label for each trial")
    if len(outcomes) != len(groups):
        message = f"there are {len(outcomes)} outcomes and {len(groups)} labels of groups"
        raise Problem("bad-statistics", message, remedy="give each trial one of both")
    for outcome, group in zip(outcomes, groups):
        try:
            counts = found.setdefault(group, [0, 0])
        except TypeError:
            message = f"a label of a group is a {type(group).__name__}, which cannot be compared with others"
            raise WrongArgument("wrong-argument", message, remedy="give one text or number for each trial, shape (trials,)") from None
        counts[0] += _succeeded(outcome)
        counts[1] += 1
    return [(successes, trials) for successes, trials in found.values()]


def clustered_rate(clusters: Sequence[Counts], *, confidence: float = 0.95) -> ClusteredRate:
    """The interval of a rate whose trials are alike within clusters: one pair ``(successes, trials)`` for each.

    >>> people = [(9, 10), (10, 10), (2, 10), (10, 10), (9, 10)]
    >>> clustered_rate(people).effective_trials < 50
    True
    """
    confidence = _checked.number(confidence, "confidence")
    total, count, method, (low, high), worth = _stats.clustered_rate(_pairs(clusters, "clusters"), confidence)
    successes, trials = total
    return ClusteredRate(successes, trials, count, low, high, confidence, method, worth[0], worth[1])


def clustering(clusters: Sequence[Counts]) -> Clustering:
    """How alike the trials of a cluster are, by analysis of variance."""
    return Clustering(*_stats.clustering(_pairs(clusters, "clusters")))


def confidence_sequence(successes: int, trials: int, *, confidence: float = 0.95) -> Rate:
    """The interval of a rate that may be looked at after every trial: with probability ``confidence`` it is never wrong, whenever
    trials stop. (An ordinary interval that is looked at until it suits is wrong more often than its level.)

    >>> sequence = confidence_sequence(88, 100)
    >>> sequence.low < rate(88, 100).low
    True
    """
    successes, trials, confidence = _trials(successes, trials, confidence)
    low, high = _stats.confidence_sequence((successes, trials), confidence)
    return Rate(successes, trials, low, high, confidence, "confidence sequence")


class RunningRate:
    """A confidence sequence that is followed trial by trial: a rate once excluded stays excluded.

    >>> running = RunningRate(confidence=0.99)
    >>> for trial in range(1000):
    ...     interval = running.observe(trial % 10 != 0)
    >>> running.low < 0.9 < running.high and running.high - running.low < 0.1
    True
    """

    __slots__ = ("_confidence", "_running")

    def __init__(self, *, confidence: float = 0.95) -> None:
        self._confidence = _checked.number(confidence, "confidence")
        self._running = _stats.RunningRate(self._confidence)

    def observe(self, success: bool) -> tuple[float, float]:
        """Takes one more trial; gives the ends of the interval now."""
        return self._running.observe(_succeeded(success))

    @property
    def low(self) -> float:
        """Lower end of the interval now."""
        return self._running.interval()[0]

    @property
    def high(self) -> float:
        """Upper end of the interval now."""
        return self._running.interval()[1]

    @property
    def rate(self) -> Rate:
        """Counts and interval now."""
        successes, trials = self._running.counts()
        return Rate(successes, trials, self.low, self.high, self._confidence, "confidence sequence")


def decide(
    successes: int, trials: int, *, threshold: float, confidence: float = 0.95
) -> Literal["at-least", "below", "open"]:
    """Whether the rate is at least the threshold; may be asked after every trial, and is ever wrong with probability at most
    ``1 - confidence``.

    >>> decide(40, 50, threshold=0.95, confidence=0.99)
    'below'
    >>> decide(96, 100, threshold=0.95, confidence=0.99)
    'open'
    """
    successes, trials, confidence = _trials(successes, trials, confidence)
    found = _stats.decide((successes, trials), _checked.number(threshold, "threshold"), confidence)
    return "at-least" if found > 0 else "below" if found < 0 else "open"


def continued_rate(looks: Sequence[Counts], *, confidence: float = 0.95) -> Rate:
    """The interval of a rate that was looked at before, with fewer trials: ``looks`` are the counts at each look, all trials so
    far each, the last one now.

    >>> once, twice = rate(20, 20), continued_rate([(9, 10), (19, 20)])
    >>> twice.trials
    20
    """
    looks, confidence = _pairs(looks, "looks"), _checked.number(confidence, "confidence")
    for (before, all_before), (now, all_now) in zip(looks, looks[1:]):
        if now < before or all_now - now < all_before - before:
            message = f"{now} of {all_now} cannot come after {before} of {all_before}"
            raise Problem("bad-statistics", message, remedy="give all trials so far at each look, the earlier ones among them")
    low, high = _stats.continued_interval(looks, confidence)
    successes, trials = looks[-1] if looks else (0, 0)
    return Rate(successes, trials, low, high, confidence, "continued")


def trials_per_arm(
    rates: tuple[float, float],
    *,
    margin: float | None = None,
    power: float = 0.8,
    confidence: float = 0.95,
) -> int | None:
    """Trials in each of two arms with these true rates, to show that they agree within ``margin``, or (without one) that they
    differ, with this probability; ``None`` if no number would do. Normal approximation.

    >>> trials_per_arm((0.9, 0.8))
    197
    >>> trials_per_arm((0.9, 0.8), margin=0.05) is None
    True
    """
    confidence, power = _checked.number(confidence, "confidence"), _checked.number(power, "power")
    return _stats.trials_per_arm(_rates(rates), _margin(margin), confidence, power)


def power(
    rates: tuple[float, float],
    trials: tuple[int, int],
    *,
    margin: float | None = None,
    confidence: float = 0.95,
) -> float:
    """The probability of showing agreement within ``margin``, or (without one) a difference, with so many trials and these true
    rates. Normal approximation.

    >>> 0.8 <= power((0.9, 0.8), (197, 197)) < 0.81
    True
    """
    first, second = _two(trials, "trials", "counts")
    trials = _checked.trials(first, "trials[0]"), _checked.trials(second, "trials[1]")
    return _stats.power(_rates(rates), trials, _margin(margin), _checked.number(confidence, "confidence"))


def paired(
    first: Iterable[Any] | None = None,
    second: Iterable[Any] | None = None,
    *,
    pairs: int | None = None,
    only_first: int | None = None,
    only_second: int | None = None,
    confidence: float = 0.95,
) -> Paired:
    """The same scenarios with two systems: outcomes (true or false) in the same order, or the counts of pairs.

    Counting both alone would take the pairs for independent samples. The interval never contradicts the test, for which it is made
    wider than Tango's (:attr:`Paired.low`).

    >>> found = paired(pairs=100, only_first=3, only_second=13)
    >>> round(found.difference, 2), round(found.low, 4), round(found.high, 4), round(found.p_value, 3)
    (0.1, 0.0244, 0.1855, 0.021)
    """
    if first is not None and second is not None:
        remedy = "give an outcome for each scenario, true or false"
        one = [_succeeded(it) for it in _checked.several(first, "first", "outcomes", remedy)]
        other = [_succeeded(it) for it in _checked.several(second, "second", "outcomes", remedy)]
        if len(one) != len(other):
            message = f"the first has {len(one)} outcomes and the second {len(other)}"
            raise Problem("bad-statistics", message, remedy="give both the same scenarios in the same order")
        pairs = len(one)
        only_first = sum(a and not b for a, b in zip(one, other))
        only_second = sum(b and not a for a, b in zip(one, other))
    if pairs is None or only_first is None or only_second is None:
        message = "pairs are given by two lists of outcomes, or by all three counts"
        raise Problem("bad-statistics", message, remedy="write paired(first, second)")
    pairs, confidence = _checked.trials(pairs, "pairs"), _checked.number(confidence, "confidence")
    only_first, only_second = _checked.trials(only_first, "only_first"), _checked.trials(only_second, "only_second")
    change, (low, high), p_value = _stats.paired(pairs, only_first, only_second, confidence)
    return Paired(pairs, only_first, only_second, change, low, high, p_value, confidence)


def holm(p_values: Iterable[float]) -> list[float]:
    """p-values adjusted for their number (Holm), in the order given; NaN counts as 1.

    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    values = _checked.several(p_values, "p_values", "p-values", "give a list of numbers from 0 to 1")
    values = [_checked.number(value, f"p_values[{place}]") for place, value in enumerate(values)]
    for value in values:
        if value < 0 or value > 1:
            raise Problem("bad-statistics", f"{value} is not a p-value", remedy="give numbers from 0 to 1")
    return _stats.holm(values)


def heterogeneity(counts: Sequence[Counts], *, confidence: float = 0.95) -> Heterogeneity:
    """Whether several rates are equal, and their mean with random effects (DerSimonian and Laird, of log odds). To all cells of all
    samples 0.5 is added (:attr:`Heterogeneity.q` says why).

    >>> heterogeneity([(90, 100), (60, 100), (95, 100)]).p_value < 0.001
    True
    """
    confidence = _checked.number(confidence, "confidence")
    (q, degrees, p_value), (i_squared, tau_squared), (pooled, (low, high)) = _stats.heterogeneity(_pairs(counts, "counts"), confidence)
    return Heterogeneity(q, degrees, p_value, i_squared, tau_squared, pooled, low, high, confidence)

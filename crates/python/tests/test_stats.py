"""Statistics against SciPy, and what refuses to be computed."""

import math

import pytest

import corroborate
from corroborate import stats

scipy_stats = pytest.importorskip("scipy.stats", reason="SciPy is not installed: nothing to hold the numbers against")


@pytest.mark.parametrize("counts", [(0, 10), (3, 17), (88, 100), (50, 50), (960, 1000)])
@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.99])
def test_intervals_are_those_of_scipy(counts, confidence):
    test = scipy_stats.binomtest(*counts)
    for ours, theirs in [("wilson", "wilson"), ("clopper-pearson", "exact")]:
        found = stats.rate(*counts, confidence=confidence, method=ours)
        expected = test.proportion_ci(confidence, method=theirs)
        assert found.low == pytest.approx(expected.low, abs=1e-9)
        assert found.high == pytest.approx(expected.high, abs=1e-9)


@pytest.mark.parametrize("counts", [(3, 17), (88, 100), (1, 40)])
@pytest.mark.parametrize("threshold", [0.05, 0.5, 0.9])
def test_tests_of_a_rate_are_those_of_scipy(counts, threshold):
    found = stats.test_rate(*counts, threshold=threshold)
    for ours, alternative in [(found.p_below, "less"), (found.p_above, "greater"), (found.p_two_sided, "two-sided")]:
        assert ours == pytest.approx(scipy_stats.binomtest(*counts, threshold, alternative).pvalue, rel=1e-8)


@pytest.mark.parametrize("first, second", [((7, 20), (15, 20)), ((80, 100), (88, 100)), ((0, 12), (4, 9))])
def test_a_difference_is_tested_by_boschloo_which_scipy_approximates(first, second):
    table = [[first[0], second[0]], [first[1] - first[0], second[1] - second[0]]]
    # SciPy's two-sided p-value is twice its one-sided one, ours orders all tables by Fisher's two-sided p-value.
    found = stats.difference(first, second)
    assert found.p_value <= scipy_stats.fisher_exact(table).pvalue * (1 + 1e-9)
    assert found.low <= found.estimate <= found.high
    assert found.estimate == pytest.approx(first[0] / first[1] - second[0] / second[1])


def test_equivalence_is_shown_by_many_alike_and_not_by_few():
    many = stats.equivalence((960, 1000), (955, 1000), margin=0.05)
    assert many.shown() and many.p_value < 1e-3
    # The trap: a large p-value of a difference is no agreement.
    few = ((18, 20), (18, 20))
    assert stats.difference(*few).p_value > 0.9 and not stats.equivalence(*few, margin=0.05).shown()


@pytest.mark.parametrize("pairs", [(100, 3, 13), (30, 0, 6), (50, 8, 8)])
def test_paired_is_the_exact_test_of_the_pairs_that_differ(pairs):
    found = stats.paired(pairs=pairs[0], only_first=pairs[1], only_second=pairs[2])
    assert found.p_value == pytest.approx(scipy_stats.binomtest(pairs[2], pairs[1] + pairs[2]).pvalue, rel=1e-9)
    first = [True] * pairs[1] + [False] * pairs[2] + [True] * (pairs[0] - pairs[1] - pairs[2])
    second = [False] * pairs[1] + [True] * pairs[2] + [True] * (pairs[0] - pairs[1] - pairs[2])
    assert stats.paired(first, second) == found


def test_clusters_are_worth_less_than_their_trials():
    people = [(9, 10), (10, 10), (2, 10), (10, 10), (9, 10), (4, 10)]
    found = stats.clustered_rate(people)
    alone = stats.rate(found.successes, found.trials)
    assert found.effective_trials < found.trials and found.high - found.low > alone.high - alone.low
    how = stats.clustering(people)
    f, p = scipy_stats.f_oneway(*[[1] * s + [0] * (n - s) for s, n in people])
    assert how.f_statistic == pytest.approx(f, rel=1e-9) and how.p_value == pytest.approx(p, rel=1e-6)


def test_clusters_come_from_columns_of_trials():
    pandas = pytest.importorskip("pandas")
    trials = pandas.DataFrame({"ok": [1, 0, 1, 1], "who": ["a", "a", "b", "a"]})
    assert stats.clusters_of(trials["ok"], trials["who"]) == [(2, 3), (1, 1)]


def test_a_running_rate_is_narrower_the_longer_it_is_followed_and_never_takes_back():
    running = stats.RunningRate(confidence=0.95)
    last = (0.0, 1.0)
    for trial in range(200):
        now = running.observe(trial % 4 != 0)
        assert now[0] >= last[0] and now[1] <= last[1]
        last = now
    assert (running.rate.successes, running.rate.trials) == (150, 200)
    assert running.low <= 0.75 <= running.high


def test_power_and_trials_are_each_others_contrary():
    needed = stats.trials_per_arm((0.95, 0.95), margin=0.05)
    assert stats.power((0.95, 0.95), (needed, needed), margin=0.05) >= 0.8
    assert stats.power((0.95, 0.95), (needed - 1, needed - 1), margin=0.05) < 0.8


def test_holm_is_that_of_scipys_neighbours():
    # By the definition: (m - i) p_(i), made monotone.
    p = [0.03, 0.001, 0.2, 0.04]
    ordered = sorted(p)
    adjusted, largest = {}, 0.0
    for place, value in enumerate(ordered):
        largest = max(largest, (len(p) - place) * value)
        adjusted[value] = min(largest, 1.0)
    assert stats.holm(p) == pytest.approx([adjusted[it] for it in p])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: stats.rate(11, 10),
        lambda: stats.rate(1, 10, confidence=95),
        lambda: stats.rate(1, 10, method="wald"),
        lambda: stats.equivalence((1, 10), (2, 10), margin=5),
        lambda: stats.equivalence((0, 0), (2, 10), margin=0.05),
        lambda: stats.difference((0, 0), (2, 10)),
        lambda: stats.test_rate(1, 10, threshold=2),
        lambda: stats.test_rate(1, 10, threshold=math.nan),
        lambda: stats.paired([True], [True, False]),
        lambda: stats.paired(pairs=3, only_first=2, only_second=2),
        lambda: stats.power((2.0, 0.5), (10, 10)),
        lambda: stats.clustering([]),
        lambda: stats.trials_per_arm((0.9, 0.8), power=1.0),
        lambda: stats.clusters_of([1.0, math.nan], ["a", "a"]),
        lambda: stats.clusters_of([True, None], ["a", "a"]),
        lambda: stats.clusters_of(["True", "False"], ["a", "a"]),
        lambda: stats.clusters_of([0.3], ["a"]),
        lambda: stats.paired([True, math.nan], [True, True]),
        lambda: stats.RunningRate().observe(None),
        lambda: stats.continued_rate([(9, 10), (5, 8)]),
        lambda: stats.continued_rate([(9, 10), (9, 9)]),
        lambda: stats.holm([2, -1]),
    ],
)
def test_what_makes_no_sense_is_a_problem(wrong):
    with pytest.raises(corroborate.Problem) as caught:
        wrong()
    assert caught.value.code == "bad-statistics" and caught.value.remedy


def test_negative_counts_are_refused():
    with pytest.raises(corroborate.Problem):
        stats.rate(-1, 10)

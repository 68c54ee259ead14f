"""Programs for which RTAMT (version 0.4.10) has open reports of wrong answers: github.com/nickovic/rtamt, issues 210, 170, 85.

The programs are ours, after what the reports describe. Where RTAMT is installed, what it says of the first is shown to be what was
reported, so that these tests go on to say something when it is corrected.
"""

import pytest

from corroborate import Formula, Verdict

np = pytest.importorskip("numpy")


def test_issue_210_until_whose_second_operand_begins_where_the_first_ends():
    """A step from 0 to 1 at 0.5 s: below holds up to there, above from there on, so "below until above" holds, by 0.5."""
    text = "(x < 0.5) until[0, 1 s] (x >= 0.5)"
    for time in ("dense", "discrete"):
        found = Formula(text, time=time).judge([0.0, 0.5], x=[0.0, 1.0])
        assert found.verdict is Verdict.SATISFIED and found.robustness.value == 0.5


def test_issue_210_is_what_rtamt_says():
    rtamt = pytest.importorskip("rtamt", reason="RTAMT is not installed: nothing to compare with")
    specification = rtamt.StlDenseTimeSpecification()
    specification.declare_var("x", "float")
    specification.spec = "(x < 0.5) until[0:1] (x >= 0.5)"
    specification.parse()
    theirs = specification.evaluate(["x", [[0.0, 0.0], [0.5, 1.0]]])
    ours = Formula("(x < 0.5) until[0, 1 s] (x >= 0.5)", time="dense").judge([0.0, 0.5], x=[0.0, 1.0])
    if theirs[0][1] == ours.robustness.value:
        pytest.skip("this version of RTAMT answers as we do")
    assert theirs[0][1] < 0 < ours.robustness.value


def test_issue_170_samples_of_several_signals_that_do_not_come_together():
    """x holds at 1 for 5 s, y comes at 7 s, and x falls only at 10 s, not within 1 s: violated, and known once 8 s are over."""
    text = "always (((historically[0, 5 s] x = 1) and y = 1) => (eventually[0, 1 s] x = 0))"
    monitor = Formula(text, time="dense", ending="inconclusive").start(["x", "y"])
    said = [monitor.step(0.0, x=1, y=0), monitor.step(1.0, x=1), monitor.step(7.0, y=1), monitor.step(10.0, x=0), monitor.step(11.0, y=0)]
    assert said[:3] == [None, None, None] and said[3] is Verdict.VIOLATED
    found = monitor.finish()
    assert found.decided_at_secs == 10.0 and 7.0 <= found.explanation.to_secs <= 10.0
    # Had x fallen within a second, it would hold.
    monitor = Formula(text, time="dense", ending="finite").start(["x", "y"])
    for time, sample in [(0.0, {"x": 1, "y": 0}), (7.0, {"y": 1}), (7.5, {"x": 0}), (11.0, {"y": 0})]:
        monitor.step(time, sample)
    assert monitor.finish().verdict is Verdict.SATISFIED


def test_issue_85_the_same_trace_is_judged_alike_however_often():
    """A formula keeps nothing of the traces that it judged."""
    text = "not ((always[0, 19 s] not (a > 0 or b > 0)) and (always[0, 19 s] (c > 0 => eventually[0, 1 s] d > 0)))"
    formula = Formula(text)
    random = np.random.default_rng(85)
    times = np.arange(20.0)
    traces = [{name: random.normal(size=20) for name in "abcd"} for _ in range(5)]
    first = [formula.judge(times, trace) for trace in traces]
    for found, trace in zip(first, traces):
        for _ in range(3):
            assert formula.judge(times, trace) == found
        assert Formula(text).judge(times, trace) == found
        a, b, c, d = (trace[name] for name in "abcd")
        # By the definition: windows are cut off by the end of the trace.
        never = min(-np.maximum(a, b))
        answered = min(max(-c[at], max(d[at : at + 2])) for at in range(20))
        assert found.robustness.value == pytest.approx(-min(never, answered), abs=1e-12)

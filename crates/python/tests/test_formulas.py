"""Formulas over arrays, data frames, recordings and streams."""

import math

import pytest

import corroborate
from corroborate import Formula, Verdict

np = pytest.importorskip("numpy")


def test_verdict_robustness_coverage_and_explanation():
    formula = Formula("always (near => eventually[0, 1 s] speed < 250 mm/s)", time="discrete")
    times = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5])
    near = np.array([False, True, True, True, False, False])
    found = formula.judge(times, near=near, speed=np.array([0.5, 0.5, 0.4, 0.3, 0.2, 0.1]), units={"speed": "m/s"})
    assert found.verdict is Verdict.VIOLATED and found.covered == 1 and found.samples == 6
    assert found.robustness.value == pytest.approx(-0.05)
    assert (found.explanation.from_secs, found.explanation.to_secs) == (0.5, 1.5)
    parts = {it.proposition: it for it in found.explanation.responsible}
    assert parts["near"].value is True and parts["speed < 250 mm/s"].signals == ("speed",)
    kept = formula.judge(times, near=near, speed=np.full(6, 0.1), units={"speed": "m/s"})
    assert kept.verdict is Verdict.SATISFIED and kept.explanation is None
    never = formula.judge(times, near=np.zeros(6, bool), speed=np.full(6, 0.1), units={"speed": "m/s"})
    assert never.verdict is Verdict.NOT_COVERED and never.covered == 0


def test_parameters_and_endings():
    times = [0.0, 1.0]
    for ending, verdict in [("long_enough", "inconclusive"), ("finite", "violated"), ("inconclusive", "inconclusive"), ("weak", "satisfied"), ("strong", "violated")]:
        formula = Formula("eventually[0, deadline] x > 0", parameters={"deadline": 5.0}, ending=ending)
        assert formula.judge(times, x=[-1.0, -2.0]).verdict == verdict
    assert Formula("eventually[0, 5 s] x > 0").judge(times, x=[-1.0, -2.0]).verdict is Verdict.INCONCLUSIVE
    assert Formula("eventually[0, 5 s] x > 0").judge(times, x=[-1.0, 2.0]).verdict is Verdict.SATISFIED
    cut = Formula("eventually[0, 5 s] x > 0").judge(times, x=[-1.0, -2.0], complete=False)
    assert cut.verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize("kind", ["pandas", "polars", "mapping"])
def test_data_frames(kind):
    data = {"time": [0.0, 1.0, 2.0], "speed": [0.1, 0.3, 0.2], "ready": [True, True, False]}
    frame = data if kind == "mapping" else pytest.importorskip(kind).DataFrame(data)
    found = Formula("always (ready => speed < 0.25)").judge(frame)
    assert found.verdict is Verdict.VIOLATED and found.decided_at_secs == 1.0
    with pytest.raises(corroborate.Problem, match="no column `t`"):
        Formula("always ready").judge(frame, time_column="t")


def test_columns_that_are_not_asked_for_may_be_anything():
    frame = {"time": [0.0, 1.0], "speed": [0.1, 0.2], "note": ["a", "b"], "none": [None, {}]}
    assert Formula("always speed < 1").judge(frame).verdict is Verdict.SATISFIED
    with pytest.raises(corroborate.Problem, match="note"):
        Formula("always velocity < 1").judge(frame)
    with pytest.raises(corroborate.Problem, match="neither numbers nor truth"):
        Formula("always note < 1").judge(frame)


def test_times_of_pandas_are_seconds_from_the_first_sample():
    pandas = pytest.importorskip("pandas")
    times = pandas.to_datetime(["2026-01-01 00:00:10", "2026-01-01 00:00:11", "2026-01-01 00:00:13"])
    frame = pandas.DataFrame({"time": times, "x": [1.0, 1.0, -1.0]})
    assert Formula("always x > 0").judge(frame).explanation.to_secs == 3.0


def test_signals_of_recordings_and_odd_names():
    found = Formula("always (/robot.speed < `/data.limit [m/s]`)").judge([0.0, 1.0], {"/robot.speed": [0.1, 0.2], "limit [m/s]": [0.3, 0.3]})
    assert found.verdict is Verdict.SATISFIED and found.robustness.value == pytest.approx(0.1)


def test_arrays_are_read_in_any_stride_and_type():
    table = np.array([[0.0, 1.0, 5.0], [1.0, 2.0, 5.0], [2.0, -3.0, 5.0]])
    found = Formula("always x > 0").judge(table[:, 0], x=table[:, 1])
    assert found.robustness.value == -3.0
    for kind in (np.float32, np.int8, np.uint64, object):
        values = np.array([1, 2, 3]).astype(kind)
        assert Formula("always x > 0").judge([0, 1, 2], x=values).robustness.value == 1.0
    backwards = np.array([3.0, 2.0, 1.0])[::-1]
    assert Formula("x > 0").judge([0.0, 1.0, 2.0], x=backwards).robustness.value == 1.0


def test_missing_values_are_unknown():
    found = Formula("always x > 0", ending="inconclusive").judge([0.0, 1.0, 2.0], x=[1.0, math.nan, 2.0])
    assert found.verdict is Verdict.INCONCLUSIVE
    assert Formula("always x > 0").judge([0.0, 1.0], x=[math.nan, -1.0]).verdict is Verdict.VIOLATED


def test_streams_give_the_verdict_when_it_is_determined_and_bounds_before():
    formula = Formula("always[0, 10 s] x > 0")
    monitor = formula.start({"x": ""})
    assert monitor.robustness is None
    assert monitor.step(0.0, x=2.0) is None and monitor.robustness.greatest == 2.0
    assert monitor.step(5.0, x=0.5) is None and monitor.robustness.greatest == 0.5
    assert monitor.step(10.5, x=-7.0) is Verdict.SATISFIED
    found = monitor.finish()
    assert found.verdict is Verdict.SATISFIED and found.robustness.value == 0.5 and found.samples == 3
    with pytest.raises(corroborate.Problem, match="ended"):
        monitor.step(11.0, x=1.0)


def test_streams_say_what_arrays_say():
    random = np.random.default_rng(7)
    formula = Formula("always (p => eventually[0, 3 s] q > 0.5)")
    for _ in range(20):
        times = np.cumsum(random.uniform(0.1, 1.0, 40))
        p, q = random.random(40) < 0.2, random.uniform(0, 1, 40)
        monitor = formula.start({"p": bool, "q": ""})
        for time, one, other in zip(times, p, q):
            monitor.step(time, p=one, q=other)
        assert monitor.finish() == formula.judge(times, p=p, q=q)


def test_memory_of_a_stream_is_bounded():
    monitor = Formula("always (x > 1 => eventually[0, 10 samples] x < 0.5)").start(["x"])
    stored = []
    for at in range(5_000):
        monitor.step(float(at), x=float(at % 7 == 0) * 2)
        stored.append(monitor.stored)
    # What explains a violation is kept from up to 10,000 samples; apart from that, windows bound it.
    assert max(stored) < 200


def test_recordings(tmp_path):
    run = tmp_path / "run.csv"
    run.write_text("time_secs,/robot.speed [m/s]\n0.0,0.1\n0.5,0.3\n1.0,0.2\n")
    report = corroborate.monitor(run, formulas=["always (/robot.speed < 250 mm/s)"])
    (found,) = report.judgements
    assert found.verdict is Verdict.VIOLATED and found.complete
    assert found.robustness.value == pytest.approx(-0.05) and found.explanation.to_secs == 0.5
    assert found.explanation.responsible[0].signals == ("/robot.speed",)
    again = Formula("always (/robot.speed < limit)", parameters={}).atoms
    assert again == ["/robot.speed < limit"]
    bounded = Formula("eventually[0, t] /robot.speed > 0.25", parameters={"t": 0.25}).judge_recordings(run)
    assert bounded.judgements[0].verdict is Verdict.VIOLATED
    events = []
    corroborate.monitor(run, formulas=["always true"], progress=events.append)
    assert {"event": "started", "stage": 0, "title": "recordings", "total": 1} in events


def test_mcap(tmp_path):
    writer_module = pytest.importorskip("mcap.writer")
    path = tmp_path / "run.mcap"
    with path.open("wb") as stream:
        writer = writer_module.Writer(stream)
        writer.start()
        text = '{"type": "object", "properties": {"speed": {"type": "number"}}}'
        schema = writer.register_schema("Robot", "jsonschema", text.encode())
        channel = writer.register_channel("/robot", "json", schema)
        for at, speed in enumerate([0.1, 0.3, 0.2]):
            stamp = at * 500_000_000
            writer.add_message(channel, stamp, f'{{"speed": {speed}}}'.encode(), stamp)
        writer.finish()
    (found,) = Formula("always (/robot.speed < 0.25)").judge_recordings(path).judgements
    assert found.verdict is Verdict.VIOLATED and found.robustness.value == pytest.approx(-0.05)


def test_a_callback_that_raises_ends_the_work(tmp_path):
    run = tmp_path / "run.csv"
    run.write_text("time_secs,/robot.speed [m/s]\n0.0,0.1\n")

    def stop(event):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        corroborate.monitor(run, formulas=["always true"], progress=stop)


@pytest.mark.parametrize(
    "wrong, code",
    [
        (lambda: Formula("always (x >"), "bad-formula"),
        (lambda: Formula("always[2, 1] x"), "bad-formula"),
        (lambda: Formula("always x", time="often"), "bad-setting"),
        (lambda: Formula("always x", ending="happy"), "bad-setting"),
        (lambda: Formula("always (speeed < 1)").judge([0.0], speed=[1.0]), "bad-predicate"),
        (lambda: Formula("always (speed < 1 s)").judge([0.0], speed=[1.0], units={"speed": "m/s"}), "bad-predicate"),
        (lambda: Formula("always x > 0").judge([0.0, 1.0], x=[1.0]), "bad-signals"),
        (lambda: Formula("always x > 0").judge([1.0, 0.0], x=[1.0, 1.0]), "bad-signals"),
        (lambda: Formula("always x > 0").judge([0.0], x=["fast"]), "bad-signals"),
        (lambda: Formula("always x > 0").judge(x=[1.0]), "bad-signals"),
        (lambda: Formula("always x > 0").judge([0.0], x=[1.0], units={"y": "m"}), "bad-signals"),
        (lambda: Formula("always x > 0").start(["x"]).step(0.0, y=1.0), "bad-signals"),
        (lambda: corroborate.monitor("/none.mcap", formulas=["always true"]), None),
    ],
)
def test_what_makes_no_sense_is_a_problem(wrong, code):
    with pytest.raises(corroborate.Problem) as caught:
        wrong()
    assert code is None or caught.value.code == code


def test_a_mistake_in_an_atom_is_placed_in_the_formula():
    with pytest.raises(corroborate.Problem) as caught:
        Formula("always (speeed < 1)").judge([0.0], speed=[1.0])
    assert (caught.value.line, caught.value.column) == (1, 9) and "speed" in caught.value.remedy


def test_weak_until_in_an_interval_is_what_its_documentation_says():
    """On all traces of five samples: as the dual of `until`, and not as `until or always`."""
    times = [0.0, 1.0, 2.0, 3.0, 4.0]
    weak = Formula("f weak_until[1 s, 3 s] g", ending="finite")
    dual = Formula("not ((not g) until[1 s, 3 s] (not f and not g))", ending="finite")
    other = Formula("f until[1 s, 3 s] g or always[1 s, 3 s] f", ending="finite")
    differ = 0
    for bits in range(1024):
        f = [bool(bits >> at & 1) for at in range(5)]
        g = [bool(bits >> (at + 5) & 1) for at in range(5)]
        verdict = weak.judge(times, f=f, g=g).verdict
        assert verdict == dual.judge(times, f=f, g=g).verdict
        # In words: f holds at each time of the interval, unless g has held until then.
        said = all(f[at] or any(g[: at + 1]) for at in (1, 2, 3))
        assert (verdict.value == "satisfied") == said, (f, g)
        differ += other.judge(times, f=f, g=g).verdict != verdict
    assert differ > 0


def test_times_may_be_dates_with_and_without_a_time_zone():
    pandas = pytest.importorskip("pandas")
    formula = Formula("eventually[0, 1 s] (speed > 1)")
    for zone in (None, "UTC", "Europe/Berlin"):
        times = pandas.to_datetime(["2024-05-13 00:00:00", "2024-05-13 00:00:01"]).tz_localize(zone)
        frame = pandas.DataFrame({"time": times, "speed": [0.0, 2.0]})
        assert formula.judge(frame).verdict is Verdict.SATISFIED
    with pytest.raises(corroborate.Problem, match="pandas.to_datetime"):
        formula.judge(["2024-05-13", "2024-05-14"], speed=[0.0, 2.0])

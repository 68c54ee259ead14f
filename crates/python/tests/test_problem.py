"""Errors are one exception, with place and remedy; a panic is named as ours."""

import pathlib
import pickle
import re
import shutil
import signal
import subprocess
import sys
import textwrap

import pytest

import corroborate
from corroborate import _engine

TEMPLATE = pathlib.Path(__file__).parents[2] / "corroborate/templates/docking"

WRONG = "dtmc\nmodule m\n  x : [0..1] init 0;\n  [] x=0 -> 0.5:(x'=1);\n  [] y=0 -> true;\nendmodule\n"


def test_a_mistake_in_a_model_has_its_place_and_the_others_beside_it():
    with pytest.raises(corroborate.Problem) as caught:
        corroborate.Model.parse("dtmc\nmodule m\n  x : [0..1;\nendmodule\n", name="grip.prism")
    problem = caught.value
    assert (problem.path, problem.line) == ("grip.prism", 3)
    assert problem.column > 1 and problem.message and problem.kind == "input"
    assert "grip.prism:3" in str(problem)


def test_a_mistake_of_meaning_is_found_when_states_are_built():
    model = corroborate.Model.parse(WRONG, name="grip.prism")
    with pytest.raises(ValueError) as caught:
        model.build()
    assert isinstance(caught.value, corroborate.Problem)
    assert caught.value.line == 4
    assert [other.line for other in caught.value.related] == [5]


def test_a_mistake_in_a_property_has_a_place_in_the_property():
    model = corroborate.Model.parse("dtmc module m x:[0..1]; [] x=0 -> (x'=1); endmodule")
    with pytest.raises(corroborate.Problem) as caught:
        model.check("P=? [ F z=1 ]")
    assert caught.value.line == 1 and "z" in caught.value.message


def test_a_file_that_is_not_there_is_a_problem_with_a_remedy(tmp_path):
    with pytest.raises(corroborate.Problem) as caught:
        corroborate.Model.load(tmp_path / "none.prism")
    assert caught.value.code == "cannot-read" and caught.value.remedy


def test_problems_can_be_pickled_with_all_they_say():
    with pytest.raises(corroborate.Problem) as caught:
        corroborate.Model.parse("dtmc module m x:[0..1; endmodule")
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.line == caught.value.line


def test_a_panic_is_an_exception_that_says_it_is_ours():
    with pytest.raises(corroborate.InternalError, match="mistake in corroborate.*asked for"):
        _engine._panic()


def test_arguments_of_the_wrong_type_are_type_errors():
    with pytest.raises(TypeError):
        corroborate.Model.parse(3)
    with pytest.raises(TypeError):
        corroborate.Model()


SLOW = """
    import corroborate, os, signal, threading, time
    model = corroborate.Model.parse("mdp module m " + "".join(f"x{i}:[0..9]; " for i in range(9))
        + "".join(f"[] x{i}<9 -> (x{i}'=x{i}+1); " for i in range(9)) + "endmodule")
    ticks = []
    def tick():
        while not done.wait(0.05):
            ticks.append(time.monotonic())
    done = threading.Event()
    beside = threading.Thread(target=tick)
    beside.start()
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        model.check("Pmax=? [ F x0=9 ]")
        print("finished")
    except KeyboardInterrupt:
        print("interrupted", len(ticks) > 5)
    finally:
        done.set()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGINT") or sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_ends_the_work_and_other_threads_go_on_meanwhile():
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(SLOW)], capture_output=True, text=True)
    assert done.stdout.strip() == "interrupted True", done.stderr


def test_importing_the_package_imports_nothing_large():
    said = "import sys, corroborate; print('numpy' in sys.modules, 'corroborate._engine' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: corroborate.Model.parse(3), "text is a str with a model in the PRISM language, not int: Model.load"),
        (lambda: corroborate.Model.load(b"m.prism"), "path is a str or a path of a model's file, not bytes"),
        (lambda: corroborate.Formula(None), "text is a str with a formula, not NoneType"),
        (lambda: corroborate.Study(7), "folder is a str or a path of a study's folder, not int: name the folder"),
    ],
)
def test_arguments_of_the_wrong_type_say_what_is_taken(call, said):
    with pytest.raises(TypeError) as caught:
        call()
    assert isinstance(caught.value, corroborate.Problem) and caught.value.code == "wrong-argument"
    assert said in f"{caught.value.message}: {caught.value.remedy}"


MODEL = "dtmc const double p; module m x:[0..1]; [] x=0 -> p:(x'=1) + 1-p:(x'=0); endmodule"


def model():
    return corroborate.Model.parse(MODEL)


def formula():
    return corroborate.Formula("always (speed < 1)")


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: corroborate.Model.parse(3), "text is a str with a model in the PRISM language, not int"),
        (lambda: model().check(3), "property is a list of texts, one text or the path of a file, not int"),
        (lambda: model().check([3]), "property[0] is a str with a property, not int"),
        (lambda: model().check("P=? [ F x=1 ]", constants=0.5), "constants is a mapping from names to values, not float"),
        (lambda: model().check("P=? [ F x=1 ]", constants={"p": None}), "the value of `p` is a number, not NoneType"),
        (lambda: model().check("P=? [ F x=1 ]", constants={"p": [0.1]}), "the value of `p` is a number, not list"),
        (lambda: model().check("P=? [ F x=1 ]", open={"p": 0.5}), "the range of `p` is a list of two numbers, not float"),
        (lambda: model().check("P=? [ F x=1 ]", open={"p": (0.1, 0.2, 0.3)}), "has 3 numbers"),
        (lambda: model().check("P=? [ F x=1 ]", constants={"p": 0.5}, precision="small"), "precision is a number, not str"),
        (lambda: model().check("P=? [ F x=1 ]", constants={"p": 0.5}, method=1), "method is a str with a name, not int"),
        (lambda: model().build(constants={"p": 0.5}, max_states=-1), "max_states must be a whole number from 0"),
        (lambda: model().build(constants={"p": 0.5}).label(1), "name is a str with a label, not int"),
        (lambda: model().build(constants={"p": 0.5}).path(seed=0.5), "seed is a whole number, not float"),
        (lambda: corroborate.Formula("always a", parameters={"late": "2 s"}), "the parameter `late` is a number, not str"),
        (lambda: formula().judge([0.0, 1.0], speed=[[1.0, 2.0]]), "`speed` has the shape (1, 2)"),
        (lambda: formula().judge([0.0, 1.0], speed=3), "`speed` is a single int"),
        (lambda: formula().judge([[0.0, 1.0]], speed=[1.0, 2.0]), "`times` has the shape (1, 2)"),
        (lambda: formula().judge(["now"], speed=[1.0]), "are not seconds"),
        (lambda: formula().judge([0.0], speed=[[1.0], [2.0, 3.0]]), "`speed` is not an array"),
        (lambda: formula().start("speed"), "signals is a list of names, not str"),
        (lambda: formula().start(["speed"]).step(0.0, speed="fast"), "speed is a number, not str"),
        (lambda: corroborate.monitor(3), "a recording is a str or a path of a recording, not int"),
        (lambda: corroborate.monitor("a.mcap", formulas="always a"), "formulas is a list of formulas, not str"),
        (lambda: corroborate.stats.rate("88", 100), "successes is a whole number, not str"),
        (lambda: corroborate.stats.rate(88.0, 100), "int(...)"),
        (lambda: corroborate.stats.rate(-1, 100), "successes must be a whole number from 0"),
        (lambda: corroborate.stats.rate(88, 100, confidence="high"), "confidence is a number, not str"),
        (lambda: corroborate.stats.difference(88, (80, 100)), "first is a pair (successes, trials), not int"),
        (lambda: corroborate.stats.difference((88, 100, 3), (80, 100)), "first is a pair (successes, trials) and has 3 entries"),
        (lambda: corroborate.stats.clustered_rate([9, 10]), "clusters[0] is a pair"),
        (lambda: corroborate.stats.power(0.9, (10, 10)), "rates is a list of rates, not float"),
        (lambda: corroborate.stats.holm(["a"]), "p_values[0] is a number, not str"),
        (lambda: corroborate.stats.paired(1, 0), "first is a list of outcomes, not int"),
        (lambda: corroborate.Study("none", out=3), "out is a str or a path of a folder, not int"),
    ],
)
def test_an_argument_of_the_wrong_kind_or_shape_is_a_problem_with_a_remedy(call, said):
    with pytest.raises(corroborate.Problem) as caught:
        call()
    assert said in str(caught.value) and caught.value.remedy
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is type(caught.value) and str(again) == str(caught.value)


def test_a_wrong_signature_is_an_ordinary_type_error():
    for call in (lambda: corroborate.stats.rate(88), lambda: corroborate.Model.parse(), lambda: corroborate.Study("a", "b")):
        with pytest.raises(TypeError) as caught:
            call()
        assert not isinstance(caught.value, corroborate.Problem)


def test_numbers_of_numpy_are_numbers():
    numpy = pytest.importorskip("numpy")
    same = corroborate.stats.rate(numpy.int64(88), numpy.uint8(100), confidence=numpy.float32(0.5))
    assert (same.low, same.trials) == (corroborate.stats.rate(88, 100, confidence=0.5).low, 100)
    counts = numpy.array([[9, 10], [10, 10], [2, 10]])
    assert corroborate.stats.clustered_rate(counts) == corroborate.stats.clustered_rate([(9, 10), (10, 10), (2, 10)])


def test_the_version_is_that_of_the_command():
    done = subprocess.run([sys.executable, "-m", "corroborate", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["corroborate", corroborate.__version__]


def test_every_code_of_the_package_is_explained():
    folder = pathlib.Path(corroborate.__file__).parent
    texts = [file.read_text() for file in folder.glob("*.py")]
    pattern = r'(?:Problem|WrongArgument|UnknownColumn)\(\s*"([a-z-]+)"'
    codes = {code for text in texts for code in re.findall(pattern, text)}
    assert {"wrong-argument", "package-missing", "bad-rig"} <= codes
    for code in sorted(codes):
        done = subprocess.run([sys.executable, "-m", "corroborate", "explain", code], capture_output=True, text=True)
        assert done.returncode == 0, (code, done.stderr)


@pytest.mark.parametrize("call", ["to_pandas", "to_polars", "to_pyarrow"])
def test_a_package_that_is_missing_is_a_problem_that_says_how_to_get_it(call, monkeypatch):
    package = call.removeprefix("to_")
    # What `import` looks at first: there is no such module.
    monkeypatch.setitem(sys.modules, package, None)
    table = object.__new__(corroborate.Table)
    with pytest.raises(corroborate.Problem) as caught:
        getattr(table, call)()
    assert (caught.value.code, caught.value.kind) == ("package-missing", "undecided")
    assert caught.value.remedy == f"pip install {package}"


def test_a_sample_that_is_refused_changes_nothing_of_a_stream():
    stream = formula().start(["speed"])
    assert stream.step(0.0, speed=0.5) is None
    for wrong in ({"speed": "fast"}, {"speed": 10**400}):
        with pytest.raises(corroborate.Problem):
            stream.step(1.0, wrong)
    assert stream.step(1.0) is None and stream.finish().verdict.value == "satisfied"


def test_a_function_at_its_pole_and_of_too_many_digits_is_a_problem():
    from corroborate._functions import RationalFunction

    with pytest.raises(corroborate.Problem, match="its denominator is 0 there"):
        RationalFunction("1 / (2 * p - 1)", ("p",))(p=0.5)
    with pytest.raises(corroborate.Problem, match="too many digits"):
        RationalFunction("p^1000000000", ("p",))(p=0.3)
    assert RationalFunction("p^1000000000", ("p",))(p=1) == 1
    for text in ("__import__('os')", "p +", "q"):
        with pytest.raises(corroborate.Problem, match="not a rational function"):
            RationalFunction(text, ("p",))(p=1)


def said(call):
    with pytest.raises(corroborate.Problem) as caught:
        call()
    return caught.value


def test_remedies_are_what_a_caller_of_python_writes(tmp_path):
    """Not one that names an option of the command line, where a function has an argument for it."""
    recording = tmp_path / "cut.csv"
    recording.write_text("time_secs,/robot.speed [m/s]\n0,0.5\n1,0.6")
    chain = corroborate.Model.parse("dtmc module m s:[0..200]; [] s<200 -> (s'=s+1); endmodule")
    study = shutil.copytree(TEMPLATE, tmp_path / "study")
    speed = ["always (/robot.speed < 1)"]
    other = ["always (/robot.other < 1)"]
    for call, expected in [
        (lambda: model().check("P=? [ F x=1 ]"), 'constants={"p": ...}'),
        (lambda: chain.check("P=? [ F s=9 ]", max_states=3), "max_states=..."),
        (lambda: corroborate.monitor(recording, formulas=speed), "partial=True"),
        (lambda: corroborate.Study(study).result(), f'Study("{study}").run()'),
        (lambda: corroborate.Study(study, out=recording).run(), "out=..."),
        (lambda: corroborate.Model.load(tmp_path / "none"), "check the name"),
    ]:
        problem = said(call)
        assert expected in problem.remedy and problem.remedy in str(problem), problem
        assert not re.search(r"(^|[ (`])--?[a-z]", problem.remedy), problem.remedy
    assert said(lambda: corroborate.monitor(tmp_path / "none.csv", formulas=other)).remedy == "check the path"


def test_a_problem_of_a_file_has_its_path_and_a_remedy(tmp_path):
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "bin.mcap").write_bytes(b"\0\1\2" * 9)
    (tmp_path / "back.csv").write_text("time_secs,/robot.speed [m/s]\n1,0.5\n0,0.6\n")
    (tmp_path / "bad.tra").write_text("x y")
    speed = ["always (/robot.speed < 1)"]
    for name, call in [
        ("none.csv", lambda path: corroborate.monitor(path, formulas=speed)),
        ("empty.csv", lambda path: corroborate.monitor(path, formulas=speed)),
        ("bin.mcap", lambda path: corroborate.monitor(path, formulas=speed)),
        ("back.csv", lambda path: corroborate.monitor(path, formulas=speed)),
        ("none.prism", corroborate.Model.load),
        ("bad.tra", lambda path: corroborate.Model.load(path).check("P=? [ F true ]")),
        ("none.props", lambda path: model().check(path, constants={"p": 0.5})),
        ("none", corroborate.Study),
    ]:
        problem = said(lambda: call(tmp_path / name))
        assert problem.path == str(tmp_path / name), problem
        assert problem.remedy, problem


def test_monitor_of_nothing_is_a_problem(tmp_path):
    assert "no recording is named" in str(said(corroborate.monitor))
    assert "neither formulas nor a study" in str(said(lambda: corroborate.monitor(tmp_path / "a.csv")))

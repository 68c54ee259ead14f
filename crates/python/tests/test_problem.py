"""Errors are one exception, with place and remedy; a panic is named as ours."""

import pickle
import signal
import subprocess
import sys
import textwrap

import pytest

import corroborate
from corroborate import _engine

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
    assert said in str(caught.value)


def test_the_version_is_that_of_the_command():
    done = subprocess.run([sys.executable, "-m", "corroborate", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["corroborate", corroborate.__version__]

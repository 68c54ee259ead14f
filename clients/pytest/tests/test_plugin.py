"""Marked tests as a user runs them, alone and by several workers. Needs the program; without it these tests are skipped."""

import csv
import os
import shutil
from xml.etree import ElementTree

import pytest

pytest_plugins = ["pytester"]

TESTS = """
import pytest
import pytest_corroborate as corroborate

opened = []

@pytest.fixture(scope="module")
def world():
    opened.append("world")

@pytest.fixture
def robot(world, seed):
    if seed % 200 == 3:
        raise RuntimeError("no simulator")
    return seed

@corroborate.requirement("REQ-7", margin=0.02)
def test_good(robot):
    assert robot % 100 != 0

@corroborate.requirement("REQ-8", margin=0.02)
def test_bad(seed):
    assert seed % 10 < 6

@corroborate.requirement("REQ-9", at_least=0.6, max_trials=40)
def test_open(seed):
    if seed % 50 == 1:
        pytest.skip("not today")
    assert seed % 10 < 6

def test_plain():
    assert opened.count("world") <= 1
"""


@pytest.fixture
def run(pytester):
    found = os.environ.get("CORROBORATE") or shutil.which("corroborate")
    if not found:
        pytest.skip("the program `corroborate` is not here")
    pytester.makepyfile(test_robot=TESTS)
    return lambda *words: pytester.runpytest_subprocess("--corroborate-program", found, *words)


def rows(path):
    with open(path, newline="") as file:
        return list(csv.reader(file))


def expected(seed):
    return "error" if seed % 200 == 3 else "fail" if seed % 100 == 0 else "pass"


def test_each_test_is_decided_once_and_its_trials_are_kept(run, pytester):
    result = run("--corroborate-out", "out", "--junitxml", "j.xml")
    result.assert_outcomes(passed=2, failed=2)
    result.stdout.fnmatch_lines(["*REQ-7: passed*", "*REQ-8: failed*", "*REQ-9: undecided*"])
    trials = rows(pytester.path / "out/test_robot.py-test_good/trials.csv")[1:]
    assert len(trials) > 40
    assert all(outcome == expected(int(seed)) for _, seed, outcome in trials)
    table = rows(pytester.path / "out/requirements.csv")
    assert table[0] == ["requirement", "covered", "passed", "failed", "undecided", "stopped"]
    assert all(len(row) == len(table[0]) and row[-1] == "yes" for row in table[1:])
    assert sorted(row[0] for row in table[1:]) == ["REQ-7", "REQ-8", "REQ-9"]
    cases = ElementTree.parse(pytester.path / "j.xml").iter("testcase")
    verified = {}
    for case in cases:
        properties = {it.get("name"): it.get("value") for it in case.iter("property")}
        if "verifies" in properties:
            verified[properties["verifies"]] = properties["outcome"]
            assert properties["guarantee"] and properties["interval"]
    assert verified == {"REQ-7": "passed", "REQ-8": "failed", "REQ-9": "undecided"}


def test_workers_share_trials_and_come_to_the_same_answer(run, pytester):
    pytest.importorskip("xdist")
    run("--corroborate-out", "one")
    result = run("--corroborate-out", "many", "-n", "3")
    result.assert_outcomes(passed=2, failed=2)
    for name in ("test_good", "test_bad", "test_open"):
        path = "test_robot.py-{}/trials.csv".format(name)
        assert rows(pytester.path / "one" / path) == rows(pytester.path / "many" / path)


def test_a_failing_seed_runs_again_as_a_plain_test(run, pytester):
    run("--corroborate-out", "out")
    trials = rows(pytester.path / "out/test_robot.py-test_bad/trials.csv")[1:]
    failing = next(seed for _, seed, outcome in trials if outcome == "fail")
    passing = next(seed for _, seed, outcome in trials if outcome == "pass")
    one = ("test_robot.py::test_bad", "--corroborate-seed")
    run(*one, failing).assert_outcomes(failed=1)
    run(*one, passing).assert_outcomes(passed=1)


def test_undecided_may_be_skipped(run):
    result = run("-k", "test_open", "--corroborate-undecided", "skip")
    result.assert_outcomes(skipped=1)


def test_a_rule_that_decides_nothing_is_refused(run, pytester):
    pytester.makepyfile(
        test_wrong="""
import pytest_corroborate as corroborate

@corroborate.requirement("A", at_least=0.99, margin=0.02)
def test_margin(seed):
    pass

@corroborate.requirement("B")
def test_no_seed():
    pass
"""
    )
    result = run("test_wrong.py")
    # Nothing was tested: errors of the tests, each with its place.
    result.assert_outcomes(errors=2)
    result.stdout.fnmatch_lines(["*test_wrong.py:3: *bad-rule*", "*test_wrong.py:7: *takes `seed`*"])


def test_a_seed_of_the_users_own_has_to_follow_from_ours(run, pytester):
    pytester.makepyfile(
        test_own="""
import pytest
import pytest_corroborate as corroborate

@pytest.fixture(params=["ours", "theirs"])
def seed(request, corroborate_seed):
    return corroborate_seed if request.param == "ours" else 5

@corroborate.requirement("A", margin=0.04)
def test_it(seed, corroborate_seed):
    assert seed == corroborate_seed
"""
    )
    run("test_own.py").assert_outcomes(passed=1, failed=1)
    pytester.makepyfile(
        test_fixed="""
import pytest
import pytest_corroborate as corroborate

@pytest.fixture
def seed():
    return 5

@corroborate.requirement("A")
def test_it(seed):
    pass
"""
    )
    result = run("test_fixed.py")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*takes `corroborate_seed`*"])


@pytest.mark.parametrize("settings", ["max_trials=0", "max_trials=-1", "max_trials=2.5", "max_errors=-1"])
def test_a_number_of_trials_that_is_none_is_refused_where_it_stands(pytester, settings):
    pytester.makepyfile(
        """
        import pytest_corroborate as corroborate

        @corroborate.requirement("REQ-7", {})
        def test_bad(seed):
            pass
        """.format(settings)
    )
    found = pytester.runpytest_subprocess()
    assert found.ret == 2
    found.stdout.fnmatch_lines(["*requirement REQ-7: {} must be a whole number*".format(settings.split("=")[0])])


def test_a_mark_without_its_name_is_refused(pytester):
    """Else it would take the test for its name, and nothing would run."""
    pytester.makepyfile("import pytest_corroborate as corroborate\n\n@corroborate.requirement\ndef test_it(seed):\n    assert False\n")
    said = pytester.runpytest_subprocess()
    assert said.ret == 2
    said.stdout.fnmatch_lines(["*a requirement needs its name: @corroborate.requirement*"])


def test_the_seed_of_a_test_that_is_not_repeated_is_an_error_that_says_what_to_do(run, pytester):
    pytester.makepyfile(
        test_unmarked="""
def test_it(seed):
    assert True

def test_with_ours(corroborate_seed):
    assert corroborate_seed is None
"""
    )
    result = run("test_unmarked.py")
    result.assert_outcomes(errors=1, passed=1)
    result.stdout.fnmatch_lines(["*test_unmarked.py:1: `seed` is the seed of a trial*@corroborate.requirement*"])


BROKEN = """
import pytest
import pytest_corroborate as corroborate

ran = []

@corroborate.requirement("IMPORT", max_trials=50)
def test_import(seed):
    ran.append(seed)
    import no_such_module_of_ours

@corroborate.requirement("NAME", max_trials=50)
def test_name(seed):
    ran.append(seed)
    assert simulated(seed)

@corroborate.requirement("FIXTURE", max_trials=50)
def test_fixture(seed, no_such_fixture):
    ran.append(seed)

@corroborate.requirement("ASYNC", max_trials=50)
async def test_coroutine(seed):
    ran.append(seed)

def test_each_was_tried_once():
    assert len(ran) == 2
"""


@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_an_error_of_the_test_is_no_failure_of_the_robot_and_ends_it_at_once(run, pytester, workers):
    pytester.makepyfile(test_broken=BROKEN)
    chosen = ("-k", "not each_was") if workers else ()
    if workers:
        pytest.importorskip("xdist")
    result = run("test_broken.py", *workers, *chosen)
    result.assert_outcomes(errors=4, passed=0 if workers else 1)
    text = result.stdout.str()
    for said in [
        "error of the test, which is not evidence about IMPORT: ModuleNotFoundError at ",
        "test_broken.py:9: No module named 'no_such_module_of_ours'",
        "which is not evidence about NAME: NameError at ",
        "there is no fixture `no_such_fixture`",
        "which is not evidence about ASYNC: it is a coroutine",
        "test_broken.py:6: error of the test",
    ]:
        assert said in text, said


def test_a_test_that_always_skips_is_skipped_with_its_reason_and_not_undecided(run, pytester):
    pytester.makepyfile(
        test_skips="""
import pytest
import pytest_corroborate as corroborate

@pytest.mark.skipif(True, reason="no robot here")
@corroborate.requirement("A")
def test_marked(seed):
    pass

@corroborate.requirement("B")
def test_within(seed):
    pytest.skip("no simulator here")

@corroborate.requirement("C", at_least=0.5)
def test_sometimes(seed):
    if seed % 2:
        pytest.skip("odd")
"""
    )
    result = run("test_skips.py", "-rs")
    result.assert_outcomes(skipped=2, passed=1)
    result.stdout.fnmatch_lines(["*A: all of the first 20 trials were skipped: *no robot here*"])
    result.stdout.fnmatch_lines(["*B: all of the first 20 trials were skipped: *no simulator here*"])


def test_tests_of_one_requirement_are_decided_each_by_itself_and_that_is_said(run, pytester):
    pytester.makepyfile(
        test_twice="""
import pytest_corroborate as corroborate

@corroborate.requirement("A", at_least=0.5)
def test_easy(seed):
    pass

@corroborate.requirement("A", at_least=0.5)
def test_hard(seed):
    assert False
"""
    )
    result = run("test_twice.py")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        ["A is verified by 2 tests, each decided by itself; it holds if all of them pass: *::test_easy, *::test_hard"]
    )
    result.stdout.fnmatch_lines(["*the test: test_twice.py:7*"])

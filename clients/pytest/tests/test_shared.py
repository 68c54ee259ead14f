"""Trials that processes share; needs nothing but Python."""

import os
import subprocess
import sys

from pytest_corroborate.shared import Trials


def test_each_number_is_taken_once_and_all_hear_of_it(tmp_path):
    one, other = Trials(str(tmp_path)), Trials(str(tmp_path))
    taken = [one.take(5), other.take(5), other.take(5), one.take(5), one.take(5)]
    assert sorted(taken) == [1, 2, 3, 4, 5]
    assert one.take(5) is None and other.take(5) is None
    one.ended(2, "fail", "it fell\nhard")
    other.ended(1, "pass")
    for trials in (one, other):
        assert trials.news() == [(2, "fail", "it fell\nhard"), (1, "pass", "")]
        assert trials.news() == []


def test_a_line_that_is_not_whole_is_read_later(tmp_path):
    trials = Trials(str(tmp_path))
    trials.ended(1, "pass")
    with open(tmp_path / "outcomes", "a") as file:
        file.write('[2, "pa')
        file.flush()
        assert trials.news() == [(1, "pass", "")]
        file.write('ss", ""]\n')
    assert trials.news() == [(2, "pass", "")]


def test_what_a_dead_process_took_is_an_error_and_what_a_living_one_took_is_not(tmp_path):
    trials = Trials(str(tmp_path))
    assert trials.take(3) == 1
    script = "from pytest_corroborate.shared import Trials; import sys; Trials(sys.argv[1]).take(3)"
    folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    environment = dict(os.environ, PYTHONPATH=folder)
    subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=True, env=environment)
    trials.bury({}, 3)
    assert [(trial, outcome) for trial, outcome, _ in trials.news()] == [(2, "error")]
    trials.bury({2: ("error", "")}, 3)
    assert trials.news() == []

import io
import json
import os
import tempfile
import unittest
from unittest import mock

from corroborate_controller import Controller, Inputs, Outputs, Setup
from corroborate_controller.coverage import FOLDER
from corroborate_controller.loop import serve


class Halting(Controller):
    name = "halting"

    def set_up(self, setup: Setup) -> None:
        self.ticks = 0

    def tick(self, inputs: Inputs) -> Outputs:
        self.ticks += 1
        if self.ticks > 2:
            return Outputs(finished=True)  # HALTS
        return Outputs()  # GOES ON


def line_of(mark: str) -> int:
    with open(__file__, encoding="utf-8") as file:
        return next(number for number, line in enumerate(file, 1) if line.rstrip().endswith(f"# {mark}"))


def episode(seed: int, ticks: int) -> str:
    setup = {"type": "setup", "seed": seed, "period_secs": 0.1, "sensors": {}, "actuators": {}, "settings": {}}
    tick = {"type": "tick", "time_secs": 0.0, "sensors": {}, "messages": []}
    return "".join(json.dumps(question) + "\n" for question in [setup, *[tick] * ticks, {"type": "end"}])


def counted(folder: str, seed: int) -> dict:
    with open(os.path.join(folder, f"{seed}.halting.info"), encoding="utf-8") as file:
        lines = file.read().splitlines()
    assert lines[0] == "SF:test_coverage.py" and lines[-1] == "end_of_record"
    return dict(tuple(map(int, line[3:].split(","))) for line in lines[1:-1])


class TestCoverage(unittest.TestCase):
    def test_each_episode_leaves_how_often_each_line_ran(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, {FOLDER: folder}):
            answers = io.StringIO()
            serve(Halting(), io.StringIO(episode(2**64 - 1, 2) + episode(7, 5)), answers)
            self.assertNotIn("error", answers.getvalue())
            short, long = counted(folder, 2**64 - 1), counted(folder, 7)
        self.assertEqual((short[line_of("GOES ON")], short[line_of("HALTS")]), (2, 0))
        self.assertEqual((long[line_of("GOES ON")], long[line_of("HALTS")]), (2, 3))
        self.assertEqual(set(short), set(long))

    def test_nothing_is_left_where_nobody_asks(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ):
            os.environ.pop(FOLDER, None)
            serve(Halting(), io.StringIO(episode(7, 5)), io.StringIO())
            self.assertEqual(os.listdir(folder), [])


if __name__ == "__main__":
    unittest.main()

import io
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from corroborate_rig import Episode, Recording, serve  # noqa: E402

STIMULUS = {"test": {"name": "t", "actions": []}, "settings": {"a.b": 1.5, "wet": True}}
PROGRAM = """
import os, sys
from corroborate_rig import Recording, main

def run(episode):
    os.write(1, b"a library that chatters\\n")
    if episode.seed == 3:
        raise ValueError("it tipped over")
    recording = Recording({"/a.x": "m"})
    recording.row(0, episode.number("a.b") + episode.seed)
    return recording

main(run)
"""


class TestRig(unittest.TestCase):
    def setUp(self) -> None:
        room = tempfile.TemporaryDirectory()
        self.addCleanup(room.cleanup)
        self.room = Path(room.name)
        self.stimulus = self.room / "stimulus.json"
        self.stimulus.write_text(json.dumps(STIMULUS), encoding="utf-8")

    def asked(self, seed: int) -> str:
        return json.dumps(
            {"type": "episode", "stimulus": str(self.stimulus), "seed": seed, "recording": str(self.room / f"{seed}.csv")}
        )

    def test_a_table_has_units_and_holes(self) -> None:
        recording = Recording({"/a.x": "m", "/a.state": "", "/b.on": ""})
        recording.row(0, 0.1, "go", False)
        recording.row(0.5, None, None, True)
        self.assertEqual(recording.text(), "time_secs,/a.x [m],/a.state,/b.on\n0.0,0.1,go,false\n0.5,,,true\n")
        with self.assertRaisesRegex(ValueError, "1 values for 3 signals"):
            recording.row(1, 2)

    def test_a_setting_that_is_missing_is_named(self) -> None:
        episode = Episode.read(self.stimulus, "7")
        self.assertEqual((episode.seed, episode.number("a.b"), episode.number("c", 2.0)), (7, 1.5, 2.0))
        for key in ("c", "wet"):
            with self.assertRaisesRegex(KeyError, f"no number `{key}`; it sets a.b, wet"):
                episode.number(key)

    def test_draws_depend_on_seed_and_purpose_alone(self) -> None:
        one, other = Episode(1, "t"), Episode(2, "t")
        self.assertEqual(one.draws("a").random(), one.draws("a").random())
        self.assertEqual(len({one.draws("a").random(), one.draws("b").random(), other.draws("a").random()}), 3)

    def test_episodes_are_answered_in_turn_and_failures_are_answers(self) -> None:
        def run(episode: Episode) -> Recording:
            if episode.seed == 2:
                raise RuntimeError("no contact")
            return Recording({"/a.x": "m"})

        answers = io.StringIO()
        stderr, sys.stderr = sys.stderr, io.StringIO()
        try:
            serve(run, io.StringIO("\n".join([self.asked(1), self.asked(2), "nonsense", self.asked(3)]) + "\n"), answers)
        finally:
            sys.stderr = stderr
        told = [json.loads(line) for line in answers.getvalue().splitlines()]
        self.assertEqual([one["type"] for one in told], ["recorded", "error", "error", "recorded"])
        self.assertEqual(told[1]["message"], "RuntimeError: no contact")
        self.assertEqual(sorted(path.name for path in self.room.glob("*.csv")), ["1.csv", "3.csv"])

    def test_both_ways_of_asking_leave_the_same_recording(self) -> None:
        program = [sys.executable, "-c", PROGRAM]
        once = self.room / "once.csv"
        done = subprocess.run([*program, str(self.stimulus), "7", str(once)], cwd=HERE, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = "\n".join(map(self.asked, (3, 7))) + "\n"
        many = subprocess.run(program, cwd=HERE, input=lines, capture_output=True, text=True)
        self.assertEqual([json.loads(line)["type"] for line in many.stdout.splitlines()], ["error", "recorded"])
        self.assertIn("a library that chatters", many.stderr)
        self.assertEqual((self.room / "7.csv").read_bytes(), once.read_bytes())
        failed = subprocess.run([*program, str(self.stimulus), "3", str(once)], cwd=HERE, capture_output=True)
        self.assertNotEqual(failed.returncode, 0)
        wrong = subprocess.run([*program, "one"], cwd=HERE, capture_output=True, text=True)
        self.assertIn("usage", wrong.stderr)


if __name__ == "__main__":
    unittest.main()

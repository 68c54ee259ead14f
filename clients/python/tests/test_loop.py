"""The client against the protocol: run with `python3 -m unittest` in `clients/python`."""

import io
import json
import math
import subprocess
import sys
import unittest
from contextlib import redirect_stderr
from pathlib import Path

from corroborate_controller import Bool, Controller, Enumeration, Inputs, Number, Outputs, Setup, serve

SETUP = {
    "type": "setup",
    "seed": 7,
    "period_secs": 0.05,
    "sensors": {"range": {"kind": "lidar", "fields": {"ranges": {"unit": "m", "length": 2}}, "facts": {"longest_m": 8}}},
    "actuators": {"drive": {"kind": "differential_drive", "fields": {"speed": {"unit": "m/s", "length": 1}}, "facts": {}}},
    "settings": {"cruise_speed_m_s": 0.5},
}


class Careful(Controller):
    name, version = "careful", "2"
    sends, receives = ("arrived",), ("go",)
    reports = {"state": Enumeration("wait", "drive"), "clear": Bool(), "ahead": Number("m")}

    def set_up(self, setup: Setup) -> None:
        self.speed = setup.settings["cruise_speed_m_s"]
        self.longest = setup.sensors["range"].facts["longest_m"]
        self.going = False

    def tick(self, inputs: Inputs) -> Outputs:
        print("this must not disturb the protocol")
        self.going |= inputs.heard("go")
        ranges = inputs.numbers("range", "ranges") or []
        ahead = min((r for r in ranges if not math.isnan(r)), default=self.longest)
        outputs = Outputs(finished=inputs.time_secs > 9)
        outputs.command("drive", speed=self.speed if self.going else 0.0)
        return outputs.report(state="drive" if self.going else "wait", clear=ahead > 1, ahead=ahead).send("arrived")


def tick(time_secs, ranges=None, messages=()):
    sensors = {} if ranges is None else {"range": {"time_secs": time_secs, "values": {"ranges": ranges}}}
    named = [{"name": name, "time_secs": time_secs} for name in messages]
    return {"type": "tick", "time_secs": time_secs, "sensors": sensors, "messages": named}


def answers(controller, *questions):
    """What the controller answers, and its error output."""
    lines = "".join((q if isinstance(q, str) else json.dumps(q)) + "\n" for q in questions)
    out, errors = io.StringIO(), io.StringIO()
    with redirect_stderr(errors):
        serve(controller, io.StringIO(lines), out)
    return [json.loads(line) for line in out.getvalue().splitlines()], errors.getvalue()


class Protocol(unittest.TestCase):
    def test_an_episode(self):
        questions = [{"type": "hello", "protocol": 1}, SETUP, tick(0.0), tick(0.05, [2.5, None], ["go"]), {"type": "end"}]
        code = "from tests.test_loop import Careful; from corroborate_controller import run; run(Careful())"
        process = subprocess.run(
            [sys.executable, "-c", code],
            input="".join(json.dumps(q) + "\n" for q in questions),
            capture_output=True,
            text=True,
            cwd=Path(__file__).parent.parent,
            check=True,
        )
        hello, ready, first, second, ended = (json.loads(line) for line in process.stdout.splitlines())
        self.assertEqual((hello["type"], hello["protocol"], hello["name"]), ("hello", 1, "careful"))
        self.assertEqual(hello["reports"]["state"], {"enumeration": {"names": ["wait", "drive"]}})
        self.assertEqual(ready, {"type": "ready"})
        self.assertEqual(first["commands"], {"drive": {"speed": 0.0}})
        self.assertEqual(first["reports"], {"state": "wait", "clear": True, "ahead": 8})
        self.assertEqual(second["commands"], {"drive": {"speed": 0.5}})
        self.assertEqual(second["reports"], {"state": "drive", "clear": True, "ahead": 2.5})
        self.assertFalse(second["finished"])
        self.assertEqual(ended, {"type": "ended"})
        self.assertIn("must not disturb", process.stderr)

    def test_a_setup_begins_anew(self):
        with redirect_stdout_to_nowhere():
            said, _ = answers(Careful(), SETUP, tick(0.0, messages=["go"]), SETUP, tick(0.0))
        self.assertEqual(said[1]["reports"]["state"], "drive")
        self.assertEqual(said[3]["reports"]["state"], "wait")

    def test_what_fails_is_told_and_the_loop_goes_on(self):
        lacking = dict(SETUP, settings={})
        said, errors = answers(Careful(), {"type": "hello", "protocol": 9}, lacking, {"type": "dance"}, "{", {"type": "end"})
        self.assertEqual([answer["type"] for answer in said], ["error"] * 4 + ["ended"])
        self.assertIn("version 9", said[0]["message"])
        self.assertIn("cruise_speed_m_s", said[1]["message"])
        self.assertIn("dance", said[2]["message"])
        self.assertIn("Traceback", errors)

    def test_a_command_that_is_no_number_is_refused(self):
        class Broken(Careful):
            def tick(self, inputs):
                return Outputs().command("drive", speed=math.nan)

        said, _ = answers(Broken(), SETUP, tick(0.0))
        self.assertIn("drive.speed", said[1]["message"])


def redirect_stdout_to_nowhere():
    from contextlib import redirect_stdout

    return redirect_stdout(io.StringIO())


if __name__ == "__main__":
    unittest.main()

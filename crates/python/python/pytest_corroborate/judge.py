"""A conversation with `corroborate decide --protocol` about one test: a line out, a line of JSON in."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys


class JudgeError(Exception):
    """The program is not there, or refuses what it is told."""


def program(named=None):
    """The words that call the program: as named, as CORROBORATE says, on the PATH, or of the Python package."""
    found = named or os.environ.get("CORROBORATE") or shutil.which("corroborate")
    if found:
        return [found]
    if importlib.util.find_spec("corroborate") is not None:
        return [sys.executable, "-m", "corroborate"]
    raise JudgeError(
        "the program `corroborate` is not on the PATH: install it, or name it with --corroborate-program"
    )


class Judge:
    """One test's judge, which has to be closed."""

    def __init__(self, call, name, settings, again, out=None):
        words = list(call) + ["-q", "decide", "--protocol", "--requirement", name]
        for key in ("at_least", "confidence", "margin", "max_trials", "max_errors", "on_error"):
            words += ["--" + key.replace("_", "-"), str(settings[key])]
        words += ["--seed", str(settings["stream"])]
        if out is not None:
            words += ["--out", str(out)]
        try:
            self._process = subprocess.Popen(
                words + ["--"] + list(again),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                universal_newlines=True,
            )
        except OSError as error:
            raise JudgeError("{} cannot be started: {}".format(call[0], error)) from error

    def _ask(self, line):
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except OSError:
            answer = ""
        if not answer:
            said = self._process.communicate()[1]
            raise JudgeError(said.strip() or "corroborate ended without a word")
        return json.loads(answer)

    def seed(self, trial):
        """The seed of a trial, numbered from 1."""
        return self._ask("seed {}".format(trial))["seed"]

    def tell(self, trial, outcome, why=""):
        """How a trial ended; whether the test is decided, or given up."""
        line = "{} {} {}".format(trial, outcome, " ".join(why.split())[:500])
        return self._ask(line.strip())["ended"]

    def report(self):
        """What was decided, on which grounds."""
        return self._ask("report")

    def close(self):
        """Ends the process."""
        if self._process.poll() is None:
            self._process.stdin.close()
            self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            pipe.close()

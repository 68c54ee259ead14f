"""Trials that several processes share: each takes the next number that is free, and all are told every outcome.

A number is taken by making its file, which one process alone can do. Outcomes are lines of one file, each written in one piece. A
process that ends in the midst of a trial leaves its number taken: whoever sees that says that the trial broke.
"""

import json
import os


class Trials:
    """The trials of one test in a folder that its processes have in common."""

    def __init__(self, folder):
        self._folder = folder
        self._read = 0
        self._next = 1
        self._lines = os.path.join(folder, "outcomes")
        os.makedirs(folder, exist_ok=True)

    def _take(self, name):
        flags = os.O_CREAT | os.O_EXCL | os.O_WRONLY
        try:
            file = os.open(os.path.join(self._folder, name), flags)
        except FileExistsError:
            return False
        os.write(file, str(os.getpid()).encode())
        os.close(file)
        return True

    def take(self, most):
        """The next trial that is free; None if all are taken."""
        while self._next <= most:
            number = self._next
            self._next += 1
            if self._take("taken-{}".format(number)):
                return number
        return None

    def stop(self, why):
        """Says to all processes that no further trial makes sense."""
        file = os.path.join(self._folder, "stopped-{}".format(os.getpid()))
        with open(file, "w", encoding="utf-8") as text:
            text.write(why)
        # Under its own name only when it is whole; who was first is heard.
        os.replace(file, os.path.join(self._folder, "stopped"))

    def stopped(self):
        """Why no further trial makes sense; None if they do."""
        try:
            with open(os.path.join(self._folder, "stopped"), encoding="utf-8") as file:
                return file.read()
        except FileNotFoundError:
            return None

    def ended(self, trial, outcome, why=""):
        """A trial has ended."""
        line = json.dumps([trial, outcome, why[:500]]) + "\n"
        file = os.open(self._lines, os.O_CREAT | os.O_APPEND | os.O_WRONLY)
        os.write(file, line.encode())
        os.close(file)

    def news(self):
        """The outcomes that were not read yet, of all processes."""
        try:
            with open(self._lines, "rb") as file:
                file.seek(self._read)
                text = file.read()
        except FileNotFoundError:
            return []
        whole = text.rfind(b"\n") + 1
        self._read += whole
        return [tuple(json.loads(line)) for line in text[:whole].splitlines()]

    def bury(self, known, most):
        """Says of trials that were taken by processes that are gone that they broke."""
        for number in range(1, most + 1):
            try:
                with open(os.path.join(self._folder, "taken-{}".format(number))) as file:
                    owner = file.read()
            except FileNotFoundError:
                return
            if number in known or not owner or _lives(int(owner)):
                continue
            # What it said last may not have been read yet.
            for trial, outcome, why in self.news():
                known[trial] = (outcome, why)
            if number not in known and self._take("broken-{}".format(number)):
                self.ended(number, "error", "the process that ran it ended")


def _lives(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True

"""Which lines of a controller run in each episode, as files in the format of lcov.

If the environment names a folder in `CORROBORATE_COVERAGE`, `run` leaves `SEED.NAME.info` there for each episode: every
line of the controller's own files that could run, with how often it did, from `set_up` to `end`. It costs time and
changes nothing else.
"""

from __future__ import annotations

import dis
import inspect
import os
import sys
from types import CodeType, FrameType
from typing import Any, Dict, Optional, Set

from .controller import Controller

FOLDER = "CORROBORATE_COVERAGE"


class Coverage:
    """Counts the lines of the files in which a controller's classes are written."""

    def __init__(self, controller: Controller, folder: str) -> None:
        ours = os.path.dirname(os.path.abspath(__file__))
        sources = set()
        for kind in type(controller).__mro__:
            source = inspect.getsourcefile(kind) if kind.__module__ != "builtins" else None
            if source and os.path.dirname(os.path.abspath(source)) != ours:
                sources.add(source)
        self.folder = folder
        self.name = "".join(letter if letter.isalnum() else "-" for letter in controller.name)
        self.lines: Dict[str, Set[int]] = {source: executable_lines(source) for source in sources}
        self.counts: Dict[str, Dict[int, int]] = {}
        self.seed: Optional[int] = None

    def begin(self, seed: int) -> None:
        """Counts from here on, for the episode with this seed."""
        self.seed = seed
        self.counts = {source: {} for source in self.lines}
        sys.settrace(self.trace)

    def end(self) -> None:
        """Writes what ran, whole or not at all."""
        sys.settrace(None)
        if self.seed is None:
            return
        os.makedirs(self.folder, exist_ok=True)
        path = os.path.join(self.folder, f"{self.seed}.{self.name}.info")
        partial = f"{path}.{os.getpid()}"
        with open(partial, "w", encoding="utf-8") as file:
            for source in sorted(self.lines):
                counts = self.counts[source]
                file.write(f"SF:{os.path.basename(source)}\n")
                for line in sorted(self.lines[source]):
                    file.write(f"DA:{line},{counts.get(line, 0)}\n")
                file.write("end_of_record\n")
        os.replace(partial, path)
        self.seed = None

    def trace(self, frame: FrameType, event: str, _: Any) -> Any:
        """Given each call; follows only those into the controller's files."""
        counts = self.counts.get(frame.f_code.co_filename)
        if counts is None:
            return None

        def follow(frame: FrameType, event: str, _: Any) -> Any:
            if event == "line":
                counts[frame.f_lineno] = counts.get(frame.f_lineno, 0) + 1
            return follow

        return follow


def of_environment(controller: Controller) -> Optional[Coverage]:
    """Counting, if the environment asks for it."""
    folder = os.environ.get(FOLDER)
    return Coverage(controller, folder) if folder else None


def executable_lines(source: str) -> Set[int]:
    """The lines inside functions of a file that can run; those outside have run when the controller is there."""
    with open(source, encoding="utf-8") as file:
        module = compile(file.read(), source, "exec")
    lines: Set[int] = set()
    for code in inner(module):
        first = code.co_firstlineno
        # The class body has run, too; a function's first line is its `def`.
        if code.co_flags & inspect.CO_OPTIMIZED:
            lines.update(line for _, line in dis.findlinestarts(code) if line and line != first)
    return lines


def inner(code: CodeType) -> Any:
    """All code inside a piece of code."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from inner(constant)

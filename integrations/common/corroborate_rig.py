"""Joins a simulator in Python to Corroborate: reads the stimulus, writes the recording, takes episodes one by one or many.

    from corroborate_rig import Episode, Recording, main

    def run(episode: Episode) -> Recording:
        recording = Recording({"/robot.speed": "m/s", "/robot.touches": ""})
        ...
        recording.row(time_secs, speed, touches)
        return recording

    main(run)

The same stimulus and seed must give the same bytes, whichever episodes the process has run before. Nothing but Python's standard
library is needed. `integrations/README.md` describes the protocol itself.
"""

from __future__ import annotations

import json
import math
import os
import random
import sys
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, TextIO, Union

Cell = Union[float, bool, str, None]


@dataclass(frozen=True)
class Episode:
    """What an episode is given."""

    seed: int
    test: str
    actions: Sequence[Mapping[str, Any]] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)

    @staticmethod
    def read(stimulus: Union[str, Path], seed: Union[int, str]) -> "Episode":
        """From the stimulus's file and the seed."""
        with open(stimulus, encoding="utf-8") as file:
            form = json.load(file)
        test = form["test"]
        return Episode(int(seed), test["name"], test["actions"], form.get("settings", {}))

    def number(self, key: str, default: float = math.nan) -> float:
        """A setting that is a number; a missing one without a default is an error that names it."""
        value = self.settings.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or math.isnan(value):
            raise KeyError(f"the stimulus sets no number `{key}`; it sets {', '.join(self.settings) or 'nothing'}")
        return float(value)

    def draws(self, purpose: str) -> random.Random:
        """Random numbers for a purpose: more of them for one purpose change nothing for another."""
        return random.Random(f"{self.seed} {purpose}")


class Recording:
    """A table in CSV: `time_secs`, and a column for each signal, `/topic.field`, with its unit ("" for none)."""

    def __init__(self, signals: Mapping[str, str]):
        self.header = ["time_secs"] + [f"{name} [{unit}]" if unit else name for name, unit in signals.items()]
        self.rows: List[str] = []

    def row(self, time_secs: float, *values: Cell) -> None:
        """A row, in the order of the signals. Times must not go back; None is no sample."""
        if len(values) + 1 != len(self.header):
            raise ValueError(f"{len(values)} values for {len(self.header) - 1} signals")
        self.rows.append(",".join([repr(float(time_secs))] + [_cell(value) for value in values]))

    def text(self) -> str:
        """The whole table."""
        return "\n".join([",".join(self.header), *self.rows]) + "\n"

    def write(self, path: Union[str, Path]) -> None:
        """Writes it whole: what is interrupted leaves nothing that looks like a recording."""
        part = Path(f"{path}.part")
        part.write_text(self.text(), encoding="utf-8")
        os.replace(part, path)


def _cell(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    # NumPy has truth values of its own.
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return "true" if value else "false"
    return repr(float(value))


Run = Callable[[Episode], Recording]


def serve(run: Run, questions: TextIO, answers: TextIO) -> None:
    """Answers each line of questions; ends when they end. What `run` raises is the answer `error`."""
    for line in questions:
        try:
            asked: Dict[str, Any] = json.loads(line)
            run(Episode.read(asked["stimulus"], asked["seed"])).write(asked["recording"])
            answer = {"type": "recorded"}
        except Exception as error:  # Whatever a simulator raises is what the episode shows.
            traceback.print_exc()
            answer = {"type": "error", "message": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


def main(run: Run, arguments: Optional[Sequence[str]] = None) -> None:
    """`STIMULUS SEED RECORDING`: one episode. Without arguments: as many as are asked for (`persistent = true`). The arguments are
    those of the program, if none are given here."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if len(given) == 3:
        run(Episode.read(given[0], given[1])).write(given[2])
        return
    if given:
        sys.exit("usage: STIMULUS SEED RECORDING, or nothing for episodes that are asked for line by line")
    # Libraries in C print to the output, which is for answers alone: from here on that is the error output.
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as answers:
        os.dup2(2, 1)
        serve(run, sys.stdin, answers)

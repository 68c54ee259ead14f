"""The loop that answers the bench line by line: version 1 of the lock-step protocol."""

from __future__ import annotations

import json
import sys
import traceback
from typing import Any, Dict, Mapping, TextIO

from . import coverage
from .controller import Controller, Inputs, Setup

PROTOCOL = 1


def run(controller: Controller) -> None:
    """Serves the bench on standard input and output until the input ends.

    While it runs, `print` writes to the error output, because the standard output belongs to the protocol.
    """
    answers = sys.stdout
    sys.stdout = sys.stderr
    try:
        serve(controller, sys.stdin, answers)
    except BrokenPipeError:
        pass
    finally:
        sys.stdout = answers


def serve(controller: Controller, questions: TextIO, answers: TextIO) -> None:
    """Answers each line of `questions` with a line on `answers`."""
    counting = coverage.of_environment(controller)
    for line in questions:
        if not line.strip():
            continue
        try:
            question = json.loads(line)
            if counting and question["type"] == "setup":
                counting.begin(question["seed"])
            answer = answer_to(controller, question)
            if counting and question["type"] == "end":
                counting.end()
            text = json.dumps(answer, allow_nan=False, separators=(",", ":"))
        except Exception as error:  # whatever the controller raises is told to the bench
            traceback.print_exc(file=sys.stderr)
            text = json.dumps({"type": "error", "message": f"{type(error).__name__}: {error}"})
        answers.write(text + "\n")
        answers.flush()


def answer_to(controller: Controller, question: Mapping[str, Any]) -> Dict[str, Any]:
    """The answer to one question."""
    kind = question["type"]
    if kind == "hello":
        return hello(controller, question["protocol"])
    if kind == "setup":
        controller.set_up(Setup.parse(question))
        return {"type": "ready"}
    if kind == "tick":
        return controller.tick(Inputs.parse(question)).form()
    if kind == "end":
        controller.end()
        return {"type": "ended"}
    raise ValueError(f"the question `{kind}` is not of version {PROTOCOL} of the protocol")


def hello(controller: Controller, protocol: int) -> Dict[str, Any]:
    """Who the controller is."""
    if protocol != PROTOCOL:
        raise ValueError(f"the bench speaks version {protocol} of the protocol, this client version {PROTOCOL}")
    return {
        "type": "hello",
        "protocol": PROTOCOL,
        "name": controller.name,
        "version": controller.version,
        "sends": list(controller.sends),
        "receives": list(controller.receives),
        "reports": {name: report.form() for name, report in controller.reports.items()},
    }

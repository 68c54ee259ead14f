"""Tests that are repeated until their rate of success is decided."""

from __future__ import annotations

from typing import Any

from . import _checked
from ._problem import Problem

__all__ = ["requirement"]


def requirement(
    name: str,
    *,
    at_least: float = 0.95,
    confidence: float = 0.95,
    margin: float = 0.0,
    max_trials: int = 400,
    max_errors: int = 10,
    on_error: str = "unknown",
    stream: int = 1,
) -> Any:
    """Marks a test of pytest that takes the fixture ``seed`` as one of the requirement ``name``: it is repeated until its rate of
    success is decided, not until it passes. Needs pytest; the plugin that repeats it comes with this package.

    ``at_least`` is the rate that is required, ``confidence`` one minus the probability of a wrong answer; rates nearer to
    ``at_least`` than ``margin`` may get either answer. At most ``max_trials`` are run, of which ``max_errors`` may break in a
    fixture; these count against either answer (``on_error="unknown"``) or as failures (``"failure"``). ``stream`` is the stream
    that seeds are drawn from.

    What is wrong with the test itself (an import that fails, a name that is not defined, a fixture that does not exist, a coroutine that
    nothing runs) does not count as a failure of the robot: it ends the test at once as an error. A test whose first 20 trials are skipped
    is skipped. Several tests of one requirement are decided each by itself; it holds if all of them pass.

    >>> import corroborate
    >>> @corroborate.requirement("REQ-7", at_least=0.95, margin=0.02)
    ... def test_grasp(seed):
    ...     assert seed >= 0
    >>> test_grasp.pytestmark[0].args
    ('REQ-7',)
    """
    remedy = "write @corroborate.requirement(\"REQ-7\") above the test"
    name = _checked.text(name, "name", "the requirement that the test verifies", remedy)
    if not name:
        raise Problem("wrong-argument", "name is empty, and a requirement needs one", remedy=remedy)
    for setting, value in (("at_least", at_least), ("confidence", confidence), ("margin", margin)):
        _checked.number(value, setting)
    max_trials, max_errors, stream = _whole(max_trials, "max_trials", 1), _whole(max_errors, "max_errors"), _whole(stream, "stream")
    if _checked.text(on_error, "on_error", "a word", "write on_error=\"unknown\"") not in ("unknown", "failure"):
        message = f"`on_error` cannot be `{on_error}`"
        raise Problem("bad-setting", message, remedy="it can be unknown, failure")
    _checked.needed("pytest", "requirement")
    import pytest_corroborate

    return pytest_corroborate.requirement(
        name,
        at_least=at_least,
        confidence=confidence,
        margin=margin,
        max_trials=max_trials,
        max_errors=max_errors,
        on_error=on_error,
        stream=stream,
    )


def _whole(value: Any, name: str, least: int = 0) -> int:
    found = _checked.whole(value, name)
    if found < least or isinstance(value, bool):
        message = f"{name} must be a whole number of at least {least} (got {value})"
        raise Problem("wrong-argument", message, remedy=f"write {name}=10, for example")
    return found

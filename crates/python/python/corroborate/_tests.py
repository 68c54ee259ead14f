"""Tests that are repeated until their rate of success is decided."""

from __future__ import annotations

from typing import Any

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

    >>> import corroborate
    >>> @corroborate.requirement("REQ-7", at_least=0.95, margin=0.02)
    ... def test_grasp(seed):
    ...     assert seed >= 0
    >>> test_grasp.pytestmark[0].args
    ('REQ-7',)
    """
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

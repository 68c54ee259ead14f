"""Repeats a seeded test until its rate of success is decided, not until it passes.

    import pytest_corroborate as corroborate

    @corroborate.requirement("REQ-7", at_least=0.95, confidence=0.95, margin=0.02, max_trials=400)
    def test_grasp(seed):
        assert simulate(seed).grasped

What is counted, and when it is enough, is said by `corroborate decide --protocol`: nothing here computes a number.
"""

import pytest

__all__ = ["requirement"]


def requirement(
    name,
    *,
    at_least=0.95,
    confidence=0.95,
    margin=0.0,
    max_trials=400,
    max_errors=10,
    on_error="unknown",
    stream=1,
):
    """Marks a test that takes `seed` as one of the requirement `name`.

    at_least    the rate of success that is required
    confidence  one minus the probability of a wrong answer
    margin      rates nearer to the required one than this may get either answer
    max_trials  how many trials are run at most
    max_errors  how many trials may break in a fixture
    on_error    what these count for: "unknown" (against either answer) or "failure"
    stream      the stream that seeds are drawn from

    What is wrong with the test itself, not with what it tests (an import that fails, a name that is not defined, a coroutine that
    nothing runs), ends it at once as an error. Several tests of one requirement are decided each by itself.
    """
    # Without parentheses it would take the test for its name, and the test would never run.
    if not isinstance(name, str) or not name:
        raise ValueError(
            "a requirement needs its name: @corroborate.requirement(\"REQ-7\") above the test (got {!r})".format(name)
        )
    for setting, value in [("max_trials", max_trials), ("max_errors", max_errors)]:
        least = 1 if setting == "max_trials" else 0
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise ValueError(
                "requirement {}: {} must be a whole number of at least {} (got {!r})".format(
                    name, setting, least, value
                )
            )
    return pytest.mark.corroborate_requirement(
        name,
        at_least=at_least,
        confidence=confidence,
        margin=margin,
        max_trials=max_trials,
        max_errors=max_errors,
        on_error=on_error,
        stream=stream,
    )

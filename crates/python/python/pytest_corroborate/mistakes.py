"""What is wrong with the test, and so is not evidence about what it tests."""

import pytest

# Raised by a test that was not written to its end, not by a robot that fails.
OF_THE_TEST = (ImportError, NameError, SyntaxError, pytest.UsageError)
# How pytest says that it did not run a coroutine: it fails in newer versions, is skipped in older ones.
NOT_RUN = "async def function"


def mistake(report):
    """Why a report is of an error of the test; None if it is of what it tests."""
    raised = getattr(report, "corroborate_raised", None)
    if raised is None:
        return None
    said = str(raised.value)
    if NOT_RUN in said:
        return (
            "it is a coroutine (`async def`), which pytest does not run by itself: install a plugin that does, "
            "for example pytest-asyncio, and mark the test as it asks"
        )
    if isinstance(raised.value, OF_THE_TEST) or type(raised.value).__name__ == "FixtureLookupError":
        return "{} at {}: {}".format(type(raised.value).__name__, place(report), first_line(raised.value))
    return None


def first_line(error):
    """The first line of what an exception says."""
    said = getattr(error, "msg", None) or str(error) or type(error).__name__
    if type(error).__name__ == "FixtureLookupError":
        said = "there is no fixture `{}`".format(error.argname)
    return str(said).strip().splitlines()[0]


def place(report):
    """Where a trial failed, as file:line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    if crash is not None:
        return "{}:{}".format(crash.path, crash.lineno)
    path, line, _ = report.location
    return "{}:{}".format(path, (line or 0) + 1)

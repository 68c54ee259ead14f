"""Arguments of the wrong kind, said in the user's words: what was given, what is taken, and what to do."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any

from ._problem import Problem, WrongArgument

__all__ = ["counts", "flag", "mapping", "number", "path", "several", "text", "whole"]


def _wrong(value: Any, name: str, wanted: str, remedy: str) -> WrongArgument:
    message = f"{name} is {wanted}, not {type(value).__name__}"
    return WrongArgument("wrong-argument", message, remedy=remedy)


def text(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A text."""
    if isinstance(value, str):
        return value
    raise _wrong(value, name, f"a str with {wanted}", remedy)


def path(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A path as a text."""
    if isinstance(value, (str, os.PathLike)):
        found = os.fspath(value)
        if isinstance(found, str):
            return found
    raise _wrong(value, name, f"a str or a path of {wanted}", remedy)


def flag(value: Any, name: str) -> bool:
    """Yes or no, and nothing that merely counts as one of them."""
    if isinstance(value, bool):
        return value
    raise _wrong(value, name, "True or False", f"write {name}=True or {name}=False")


def number(value: Any, name: str) -> float:
    """A number: also one of NumPy, a fraction or a decimal number, but not a text that could be read as one."""
    if not isinstance(value, (str, bytes)) and (hasattr(value, "__float__") or hasattr(value, "__index__")):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    raise _wrong(value, name, "a number", "give a number, for example 0.95")


def whole(value: Any, name: str) -> int:
    """A whole number that is not negative."""
    try:
        found = operator.index(value)
    except TypeError:
        raise _wrong(value, name, "a whole number", "give a count, for example 100; int(...) makes one of a float") from None
    if not 0 <= found < 2**64:
        message = f"{name} must be a whole number from 0 to 2^64 - 1 (got {found})"
        raise Problem("wrong-argument", message, remedy="give a count, for example 100")
    return found


def counts(value: Any, name: str) -> tuple[int, int]:
    """Successes and trials."""
    remedy = "give (successes, trials), for example (88, 100)"
    try:
        found = None if isinstance(value, (str, bytes)) else tuple(value)
    except TypeError:
        found = None
    if found is None:
        raise _wrong(value, name, "a pair (successes, trials)", remedy)
    if len(found) != 2:
        message = f"{name} is a pair (successes, trials) and has {len(found)} entries"
        raise Problem("wrong-argument", message, remedy=remedy)
    return whole(found[0], f"successes in {name}"), whole(found[1], f"trials in {name}")


def several(value: Any, name: str, wanted: str, remedy: str) -> list[Any]:
    """What can be gone through; a text cannot, since its letters are not what is meant."""
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        return list(value)
    raise _wrong(value, name, f"a list of {wanted}", remedy)


def mapping(value: Any, name: str, wanted: str, remedy: str) -> Mapping[Any, Any]:
    """A mapping."""
    if isinstance(value, Mapping):
        return value
    raise _wrong(value, name, f"a mapping from names to {wanted}", remedy)

"""Arguments of the wrong kind, said in the user's words: what was given, what is taken, and what to do.

Every public function looks at its arguments with these before the engine sees them, so that what is wrong is always a
:class:`~corroborate.Problem`, and never an error of the conversion between the languages.
"""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Iterable, Mapping
from types import ModuleType
from typing import Any, TypeVar, Union

from ._problem import Problem, WrongArgument

__all__ = ["counts", "flag", "instance", "mapping", "needed", "number", "optional_callback", "path", "several", "shown", "text", "trials", "whole"]

T = TypeVar("T")
# Beyond this a double does not tell a number from the next.
_MOST = 2**53


def _wrong(value: Any, name: str, wanted: str, remedy: str) -> WrongArgument:
    message = f"{name} is {wanted}, not {type(value).__name__}"
    return WrongArgument("wrong-argument", message, remedy=remedy)


def text(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A text, which can be written as UTF-8: half a surrogate pair cannot."""
    if not isinstance(value, str):
        raise _wrong(value, name, f"a str with {wanted}", remedy)
    try:
        value.encode()
    except UnicodeEncodeError as error:
        message = f"{name} has half a character at place {error.start} ({ascii(value[error.start])}), which no text can have"
        raise Problem("wrong-argument", message, remedy="decode what it was read from with the encoding that it has") from None
    return str(value)


def path(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A path as a text."""
    found = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if not isinstance(found, str):
        raise _wrong(value, name, f"a str or a path of {wanted}", remedy)
    try:
        is_possible = b"\0" not in os.fsencode(found)
    except UnicodeEncodeError:
        is_possible = False
    if not is_possible or not found:
        said = ascii(found) if found else "empty"
        raise Problem("wrong-argument", f"{name} cannot be the path of a file: it is {said}", remedy=remedy)
    return found


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
        except OverflowError:
            raise Problem("wrong-argument", f"{name} is beyond the largest float", remedy="give a number below 1.8e308") from None
        except (TypeError, ValueError):
            pass
    raise _wrong(value, name, "a number", "give a number, for example 0.95")


def whole(value: Any, name: str, most: int = 2**64 - 1) -> int:
    """A whole number that is not negative."""
    try:
        found = operator.index(value)
    except TypeError:
        raise _wrong(value, name, "a whole number", "give a count, for example 100; int(...) makes one of a float") from None
    if not 0 <= found <= most:
        bound = {2**64 - 1: "2^64 - 1", _MOST: "2^53"}.get(most, str(most))
        # A number of thousands of digits tells nobody anything, and Python refuses to write it.
        given = str(found) if abs(found) < 10**30 else f"a number of {found.bit_length()} bits"
        message = f"{name} must be a whole number from 0 to {bound} (got {given})"
        raise Problem("wrong-argument", message, remedy="give a count, for example 100")
    return found


def counts(value: Any, name: str) -> tuple[int, int]:
    """Successes and trials."""
    remedy = "give (successes, trials), for example (88, 100)"
    try:
        found = None if isinstance(value, (str, bytes, Mapping)) else tuple(value)
    except TypeError:
        found = None
    if found is None:
        raise _wrong(value, name, "a pair (successes, trials)", remedy)
    if len(found) != 2:
        message = f"{name} is a pair (successes, trials) and has {len(found)} entries"
        raise Problem("wrong-argument", message, remedy=remedy)
    return trials(found[0], f"successes in {name}"), trials(found[1], f"trials in {name}")


def trials(value: Any, name: str) -> int:
    """A count of trials."""
    return whole(value, name, _MOST)


def several(value: Any, name: str, wanted: str, remedy: str) -> list[Any]:
    """What can be gone through; a text cannot, since its letters are not what is meant."""
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        try:
            return list(value)
        except TypeError:
            # An array of no dimensions says that it can be gone through.
            pass
    raise _wrong(value, name, f"a list of {wanted}", remedy)


def mapping(value: Any, name: str, wanted: str, remedy: str) -> Mapping[str, Any]:
    """A mapping from names."""
    if not isinstance(value, Mapping):
        raise _wrong(value, name, f"a mapping from names to {wanted}", remedy)
    for key in value:
        text(key, f"a name in {name}", "a name", remedy)
    return value


def optional_callback(value: Any, name: str) -> Union[Callable[..., Any], None]:
    """What can be called, or nothing."""
    if value is None:
        return None
    if callable(value):
        call: Callable[..., Any] = value
        return call
    raise _wrong(value, name, "a function or None", f"write {name}=print, for example")


def instance(value: Any, name: str, kind: type[T], wanted: str, remedy: str) -> T:
    """An object of this package."""
    if isinstance(value, kind):
        return value
    raise _wrong(value, name, wanted, remedy)


def needed(package: str, what: str, *, module: Union[str, None] = None) -> ModuleType:
    """A package that only some functions need."""
    import importlib

    try:
        return importlib.import_module(module or package)
    except ImportError:
        message, remedy = f"{what} needs {package}, which is not installed", f"pip install {package}"
    except SyntaxError as error:
        message, remedy = f"{what} needs {package}, which this Python cannot read: {error}", "use a newer Python"
    raise Problem("package-missing", message, remedy=remedy, kind="undecided")


def shown(value: Any) -> str:
    """A value for a message: Python refuses to write numbers of thousands of digits, and nobody reads a page."""
    try:
        said = str(value)
    except Exception:  # Whatever an object's own text raises.
        return f"a value of the type {type(value).__name__}"
    return said if len(said) <= 60 else said[:60] + "..."

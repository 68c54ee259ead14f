"""Arguments of the wrong type, said in the user's words: what was given, what is taken, and what to do."""

from __future__ import annotations

import os
from typing import Any

__all__ = ["path", "text"]


def text(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A text, or a TypeError with the remedy."""
    if isinstance(value, str):
        return value
    raise TypeError(f"{name} is a str with {wanted}, not {type(value).__name__}: {remedy}")


def path(value: Any, name: str, wanted: str, remedy: str) -> str:
    """A path as a text, or a TypeError with the remedy."""
    if isinstance(value, (str, os.PathLike)):
        found = os.fspath(value)
        if isinstance(found, str):
            return found
    raise TypeError(f"{name} is a str or a path of {wanted}, not {type(value).__name__}: {remedy}")

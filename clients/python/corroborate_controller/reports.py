"""What a controller may report of its inside, for the recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Sequence, Tuple, Union


@dataclass(frozen=True)
class Number:
    """A number in a unit, for example `Number("m")`; `"1"` if it has none."""

    unit: str

    def form(self) -> Dict[str, Any]:
        """As the protocol has it."""
        return {"number": {"unit": self.unit}}


@dataclass(frozen=True)
class Bool:
    """A truth value."""

    def form(self) -> Dict[str, Any]:
        """As the protocol has it."""
        return {"bool": {}}


@dataclass(frozen=True)
class Enumeration:
    """One of some names, for example `Enumeration("drive", "stop")`; reported as the name."""

    names: Tuple[str, ...]

    def __init__(self, *names: str) -> None:
        object.__setattr__(self, "names", tuple(names))

    def form(self) -> Dict[str, Any]:
        """As the protocol has it."""
        return {"enumeration": {"names": list(self.names)}}


Report = Union[Number, Bool, Enumeration]

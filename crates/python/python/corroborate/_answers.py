"""Answers of a model checker, and how they compare with numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Union

from . import _checked
from ._functions import Parametric
from ._problem import Problem, WrongArgument

__all__ = ["Answer", "Witness", "as_fraction"]

Value = Union[bool, float, Fraction, None]


@dataclass(frozen=True)
class Witness:
    """The most probable path that shows why."""

    violates: bool
    """Whether it violates the path formula; else it satisfies it."""
    probability: float
    states: tuple[str, ...]
    """Its states, each as ``(name=value,...)``."""
    actions: tuple[Union[str, None], ...]


@dataclass(frozen=True, eq=False, repr=False)
class Answer:
    """The answer to a property: a value, and what is known of it.

    An answer compares with numbers by what is *known*, not by its value: ``answer >= 0.9`` is true if the lower bound is at
    least 0.9, false if the upper bound is below, and raises :class:`corroborate.Problem` (``undecided-comparison``) if the bounds
    lie on both sides, or if it is an estimate, which has no bounds. Compare ``answer.value`` to compare the number alone.
    Beside an exact answer a float is taken for the decimal number that it prints as, so that an exact 9/10 is equal to 0.9.

    >>> import corroborate
    >>> die = corroborate.Model.parse("dtmc module m x:[0..2]; [] x=0 -> 0.75:(x'=1) + 0.25:(x'=2); endmodule")
    >>> answer = die.check("P=? [ F x=1 ]")
    >>> answer.guarantee, answer.lower <= 0.75 <= answer.upper
    ('bounded', True)
    >>> answer >= 0.7, answer > 0.8
    (True, False)
    >>> die.check("P=? [ F x=1 ]", method="exact").value
    Fraction(3, 4)
    """

    property: str
    """The property's text."""
    value: Value
    """A probability or expectation (in the unit of the reward or, for times, of the model); ``True`` or ``False`` of a property
    with a bound; ``None`` where there is no single value (:attr:`text` has what there is)."""
    lower: Union[float, Fraction, None]
    """The value is at least this; ``None`` of an estimate and of truth values."""
    upper: Union[float, Fraction, None]
    """The value is at most this; ``None`` of an estimate and of truth values."""
    guarantee: str
    """``exact``, ``bounded``, ``statistical`` or ``estimated``."""
    text: str
    """The value as it is printed."""
    method: str
    """How it was computed."""
    name: Union[str, None] = None
    """The property's name, if it has one."""
    constants: Mapping[str, Fraction] = field(default_factory=dict)
    """The values of the constants that ran over ranges."""
    complement: Union[float, None] = None
    """One minus the value, computed directly: it keeps its digits where the value is close to 1."""
    iterations: int = 0
    seconds: float = 0.0
    """For the answer, without building the states."""
    notes: tuple[str, ...] = ()
    """What to know besides, for example why a value is only an estimate."""
    states: Mapping[str, str] = field(default_factory=dict)
    """What the property's filters list: the value in each state, which is written as ``(name=value,...)``."""
    witness: Union[Witness, None] = None
    parametric: Union[Parametric, None] = None
    """With constants left open: the value as functions of these."""
    unfinished: Union[str, None] = None
    """``stopped`` if a limit ended the work: then the bounds are those reached so far."""
    certificate: Union[Mapping[str, Any], None] = None
    """What became of checking the answer again with other code, if that was asked for."""

    __hash__ = object.__hash__

    def __repr__(self) -> str:
        bounds = "" if self.guarantee != "bounded" else f" in [{self.lower!r}, {self.upper!r}]"
        return f"<Answer {self.text}{bounds} ({self.guarantee}): {self.property}>"

    def __bool__(self) -> bool:
        if isinstance(self.value, bool):
            return self.value
        raise TypeError(f"{self.property} has a number for an answer: compare it, for example `answer >= 0.9`")

    def __float__(self) -> float:
        if isinstance(self.value, bool) or self.value is None:
            raise TypeError(f"the answer to {self.property} is {self.text}, which is not a number")
        return float(self.value)

    def __ge__(self, other: object) -> bool:
        return self._compared(other, ">=", lambda low, at: low >= at, lambda high, at: high < at)

    def __gt__(self, other: object) -> bool:
        return self._compared(other, ">", lambda low, at: low > at, lambda high, at: high <= at)

    def __le__(self, other: object) -> bool:
        low, high = (lambda low, at: low > at), (lambda high, at: high <= at)
        return not self._compared(other, "<=", low, high)

    def __lt__(self, other: object) -> bool:
        low, high = (lambda low, at: low >= at), (lambda high, at: high < at)
        return not self._compared(other, "<", low, high)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, bool) and isinstance(self.value, bool):
            return self.value == other
        if isinstance(other, Answer) or not _is_number(other):
            return self is other if isinstance(other, Answer) else NotImplemented
        low, high, at = self._bounds("==", other)
        if not low <= at <= high:
            return False
        if low == high:
            return True
        raise self._undecided("==", other)

    def _compared(self, other: object, sign: str, above: Any, below: Any) -> bool:
        if not _is_number(other):
            message = f"an answer compares with numbers, not with {type(other).__name__}"
            raise WrongArgument("wrong-argument", message, remedy="compare its bounds, `.lower` and `.upper`, or `.value`")
        low, high, at = self._bounds(sign, other)
        if above(low, at):
            return True
        if below(high, at):
            return False
        raise self._undecided(sign, other)

    def _bounds(self, sign: str, other: Any) -> tuple[Any, Any, Any]:
        """The bounds, and what they are compared with: beside bounds that are floats a float is itself."""
        if self.lower is None or self.upper is None:
            if isinstance(self.value, bool):
                raise TypeError(f"the answer to {self.property} is {self.text}, which is not a number")
            raise self._undecided(sign, other)
        is_exact = isinstance(self.lower, Fraction)
        at = other if isinstance(other, (int, Fraction)) else as_fraction(other) if is_exact else float(other)
        return self.lower, self.upper, at

    def _undecided(self, sign: str, other: object) -> Problem:
        if self.lower is None:
            reason = f"the value {self.text} is {self.guarantee}, without bounds"
            remedy = 'check it with method="sound" or "exact", or compare `.value` and rely on the estimate'
        else:
            reason = f"it lies between {self.lower!r} and {self.upper!r}"
            remedy = 'check it with a smaller `precision` or with method="exact", or compare `.value`'
        message = f"whether {self.property} {sign} {_checked.shown(other)} is not decided: {reason}"
        return Problem("undecided-comparison", message, remedy=remedy, kind="undecided")

    def __iter__(self) -> Iterator[Any]:
        raise TypeError("an answer is not a list: its bounds are `.lower` and `.upper`")


def _is_number(it: object) -> bool:
    # Numbers of NumPy, too, without importing it; an array of several is none.
    is_like_one = not isinstance(it, (bool, str)) and hasattr(it, "__float__") and not isinstance(it, Answer)
    return is_like_one and getattr(it, "ndim", 0) == 0


def as_fraction(number: Any) -> Any:
    """The number as a fraction: a float as the decimal number that it prints as."""
    if isinstance(number, (int, Fraction)):
        return number
    value = float(number)
    if value != value or value in (float("inf"), float("-inf")):
        return value
    return Fraction(repr(value))

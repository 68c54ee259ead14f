"""Rational functions of a model's constants."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Union

from . import _checked
from ._problem import Problem

__all__ = ["Parametric", "Part", "RationalFunction", "parametric"]

_OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}

# Digits in base two of the largest exact power: computed within a second.
_MOST_BITS = 10_000_000

Region = dict[str, tuple[Fraction, Fraction]]


@dataclass(frozen=True)
class RationalFunction:
    """A function of constants that were left open: call it with their values.

    >>> half = RationalFunction("(p^2 + 1) / (2 * p)", ("p",))
    >>> half(p=0.5)
    Fraction(5, 4)
    """

    text: str
    """In PRISM's syntax."""
    parameters: tuple[str, ...]

    def __call__(self, **values: Any) -> Union[Fraction, float]:
        """Its value: exactly, a float being taken for the decimal number that it prints as."""
        missing = [name for name in self.parameters if name not in values]
        unknown = [name for name in values if name not in self.parameters]
        if missing or unknown:
            message = f"the function has the parameters {', '.join(self.parameters)} (got {', '.join(values) or 'none'})"
            raise Problem("bad-parameters", message, remedy=f"call it with {', '.join(f'{it}=...' for it in self.parameters)}")
        exact = {name: _fraction(value) for name, value in values.items()}
        try:
            value: Union[Fraction, float] = _evaluated(self._tree, exact)
        except ZeroDivisionError:
            message = f"the function has no value at {_point(values)}: its denominator is 0 there"
            raise Problem("bad-parameters", message, remedy="give another point; `derivatives` may be there, too") from None
        return value

    @cached_property
    def _tree(self) -> ast.expr:
        try:
            return ast.parse(self.text.replace("^", "**"), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise _not_a_function(self.text) from None

    def __str__(self) -> str:
        return self.text


def _fraction(value: Any) -> Fraction:
    if isinstance(value, (int, Fraction)):
        return Fraction(value)
    number = _checked.number(value, "a parameter's value")
    if not math.isfinite(number):
        raise Problem("bad-parameters", f"a parameter's value must be finite (got {number})", remedy="give a number, for example 0.5")
    return Fraction(repr(number))


def _point(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={_checked.shown(value)}" for name, value in values.items())


def _not_a_function(text: str) -> Problem:
    said = text if len(text) < 100 else text[:100] + "..."
    return Problem("bad-parameters", f"`{said}` is not a rational function", remedy="take functions from an answer's `parametric`")


def _power(base: Fraction | float, exponent: int) -> Fraction | float:
    """A power, unless its digits alone would take minutes."""
    if isinstance(base, Fraction):
        digits = max(abs(base.numerator), base.denominator).bit_length() if base not in (0, 1, -1) else 0
        if digits * abs(exponent) > _MOST_BITS:
            message = f"a power in the function has the exponent {exponent}, so that its exact value has too many digits"
            raise Problem("bad-parameters", message, remedy="give values with fewer digits, for example 0.5")
    return base**exponent


def _evaluated(node: ast.expr, values: Mapping[str, Fraction]) -> Any:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return Fraction(repr(node.value))
    if isinstance(node, ast.Name):
        known = {"Infinity": float("inf"), "NaN": float("nan"), **values}
        if node.id not in known:
            raise _not_a_function(node.id)
        return known[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_evaluated(node.operand, values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        return _power(_evaluated(node.left, values), int(_evaluated(node.right, values)))
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        left, right = _evaluated(node.left, values), _evaluated(node.right, values)
        return _OPERATORS[type(node.op)](left, right)
    raise _not_a_function(ast.unparse(node))


@dataclass(frozen=True)
class Part:
    """A part of the region, at all points strictly inside of which the answer is one function."""

    region: Region
    """A range for each open constant."""
    function: RationalFunction
    """The value in the (first) initial state."""
    derivatives: Mapping[str, RationalFunction]
    """By each open constant; empty where they would be too large."""


@dataclass(frozen=True)
class Parametric:
    """An answer as functions of constants that were left open."""

    parameters: tuple[str, ...]
    parts: tuple[Part, ...]
    undecided: tuple[Region, ...]
    """Parts without an answer: which choice is best, or whether a bound is met, differs inside."""
    ill_defined: tuple[Region, ...]
    """Parts in which a probability is negative everywhere."""
    conditions: tuple[str, ...]
    """What must hold at a point for the answer to hold there."""
    conditions_hold: bool
    """Whether all conditions are known to hold on the whole region."""

    def __call__(self, **values: Any) -> Union[Fraction, float]:
        """The value at a point, exactly: by the function of the part in which it lies.

        Raises:
            Problem: if the point lies in no part that has an answer.
        """
        exact = {name: _fraction(value) for name, value in values.items()}
        for part in self.parts:
            if all(low <= exact.get(name, low - 1) <= high for name, (low, high) in part.region.items()):
                return part.function(**values)
        raise Problem("bad-parameters", f"there is no answer at {_point(values)}", remedy="give each parameter a value of its range, outside of `undecided`")


def parametric(report: Mapping[str, Any]) -> Parametric:
    """From the engine's report."""
    names = tuple(report["parameters"])

    def region(ranges: list[dict[str, str]]) -> Region:
        return {name: (Fraction(it["low"]), Fraction(it["high"])) for name, it in zip(names, ranges)}

    def part(found: Mapping[str, Any]) -> Part:
        value = found["values"][0]
        derivatives = zip(names, value["derivatives"])
        return Part(
            region(found["region"]),
            RationalFunction(value["function"], names),
            {name: RationalFunction(text, names) for name, text in derivatives},
        )

    return Parametric(
        names,
        tuple(part(it) for it in report["parts"]),
        tuple(region(it) for it in report["undecided"]),
        tuple(region(it) for it in report["ill_defined"]),
        tuple(f"{it['function']} {it['relation']}" for it in report["conditions"]),
        report["conditions_hold"],
    )

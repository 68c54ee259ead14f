"""Plots with matplotlib, which is imported only here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Union

from . import _checked
from ._problem import Problem, WrongArgument

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._studies import StudyResult

__all__ = ["forest_plot"]

_MARKS = {"model-checking": "D", "simulation": "o", "experiment": "s", "operation": "^"}


def forest_plot(result: StudyResult, ax: Union[Axes, None] = None, subject: Union[str, None] = None) -> Axes:
    """Each piece of evidence in a row: the rate or probability, its interval, and what is required as a dashed line."""
    pyplot = _checked.needed("matplotlib", "forest_plot", module="matplotlib.pyplot")
    if subject is not None:
        _checked.text(subject, "subject", "a requirement or failure mode", f"name one of {', '.join(result.requirements)}")
    if ax is not None and not hasattr(ax, "set_yticks"):
        message = f"ax is an Axes of matplotlib or None, not {type(ax).__name__}"
        raise WrongArgument("wrong-argument", message, remedy="make one with matplotlib.pyplot.subplots()")
    rows = [it for it in result.evidence.rows() if it["estimate"] is not None and _is_asked(it, subject)]
    if not rows:
        raise Problem("no-evidence", f"there is no figure on {subject or 'any requirement'}", remedy="name a requirement or failure mode")
    if ax is None:
        _, ax = pyplot.subplots(figsize=(7, 1 + 0.35 * len(rows)), layout="constrained")
    for place, row in enumerate(rows):
        at = len(rows) - 1 - place
        low, high = row["low"] or 0.0, 1.0 if row["high"] is None else row["high"]
        ax.plot([low, high], [at, at], color="0.3", linewidth=1.5, zorder=1)
        ax.plot(row["estimate"], at, marker=_MARKS.get(row["technique"], "o"), color="0.1", linestyle="none", zorder=2)
    _thresholds(result, ax, rows)
    ax.set_yticks(range(len(rows)), [_label(row, subject) for row in reversed(rows)])
    ax.set_xlabel(f"rate or probability (intervals at {result.confidence * 100:g} %)")
    ax.set_ylim(-0.6, len(rows) - 0.4)
    return ax


def _is_asked(row: dict[str, Any], subject: Union[str, None]) -> bool:
    return bool(row["kind"] == "requirement" if subject is None else row["subject"] == subject)


def _label(row: dict[str, Any], subject: Union[str, None]) -> str:
    counts = f" {row['count']}/{row['trials']}" if row["trials"] else ""
    return f"{row['subject']}: {row['evidence']}{counts}" if subject is None else f"{row['evidence']}{counts}"


def _thresholds(result: StudyResult, ax: Axes, rows: list[dict[str, Any]]) -> None:
    requirements = result.requirements
    for place, row in enumerate(rows):
        required = requirements.get(row["subject"]) if row["kind"] == "requirement" else None
        if required is not None:
            at = len(rows) - 1 - place
            ax.plot([required.threshold] * 2, [at - 0.5, at + 0.5], color="0.5", linestyle="--", linewidth=1, zorder=0)

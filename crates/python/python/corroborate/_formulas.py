"""Formulas of temporal logic: over arrays and data frames, over recordings, and sample by sample."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, Literal, Union

from . import _checked, _engine
from ._problem import Problem

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "Explanation",
    "Formula",
    "Judgement",
    "Monitor",
    "RecordingJudgement",
    "RecordingsReport",
    "Responsible",
    "Robustness",
    "Verdict",
    "monitor",
]

_UNCHANGED: Mapping[str, float] = {}

Ending = Literal["long_enough", "finite", "inconclusive", "weak", "strong"]
PathLike = Union[str, os.PathLike[str]]


class Verdict(str, Enum):
    """What is concluded of one trace."""

    SATISFIED = "satisfied"
    VIOLATED = "violated"
    NOT_COVERED = "not-covered"
    """Nothing was violated, but what the requirement waits for never came."""
    INCONCLUSIVE = "inconclusive"
    """The trace ended before a verdict."""

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True)
class Robustness:
    """By how much a formula is satisfied (above 0) or violated (below 0), in the SI unit of what it compares."""

    least: float
    """Not less than this, given what was seen; minus infinity if there is no limit."""
    greatest: float
    """Not more than this."""

    @property
    def value(self) -> Union[float, None]:
        """The robustness itself, if it is known."""
        return self.least if self.least == self.greatest else None


@dataclass(frozen=True)
class Responsible:
    """What is part of the reason for a violation."""

    proposition: str
    """The text of the comparison or proposition."""
    value: bool
    """What it was there."""
    from_secs: float
    to_secs: float
    signals: tuple[str, ...]
    """The signals that it reads."""


@dataclass(frozen=True)
class Explanation:
    """The part of a trace that by itself shows a violation, whatever the signals are elsewhere."""

    from_secs: float
    to_secs: float
    """Where the violation shows."""
    responsible: tuple[Responsible, ...]


@dataclass(frozen=True)
class Judgement:
    """What a formula says of one trace, at its first sample."""

    verdict: Verdict
    robustness: Union[Robustness, None]
    """``None`` without samples."""
    covered: Union[int, None]
    """How often the requirement was put to the test: how often `a` of ``always (a => b)`` became true; ``None`` of other
    formulas."""
    samples: int
    decided_at_secs: Union[float, None]
    """The time of the sample that determined the verdict; ``None`` if only the end did."""
    explanation: Union[Explanation, None]
    """Of a violation."""
    ends_before: Union[str, None] = None
    """How long the trace would have to be from its first trigger on (``"5 s"``), if the verdict is open only because it ends
    before."""
    left_out: Union[str, None] = None
    """Within what of its end something began that is pending there (``"5 s"``), if the verdict leaves that out."""


class Formula:
    """A formula of metric or signal temporal logic.

    Args:
        text: for example ``always (near => eventually[0, 2 s] speed < 250 mm/s)``. ``corroborate explain formula``
            has the operators. Names are columns; signals of recordings are written ``/topic.field``.
        parameters: values in seconds of names that stand in intervals.
        time: ``discrete`` (only samples count) or ``dense`` (signals have values between samples).
        interpolation: in dense time, ``hold`` (the last value) or ``linear`` (robustness in straight lines).
        ending: what is said of times behind the end: ``long_enough`` (the trace is all there is, but a bounded window that its
            end cuts violates nothing: it is left out, or the verdict is open if none was seen whole), ``finite`` (it is all there is),
            ``inconclusive`` (nothing), ``weak`` (the benefit of the doubt), ``strong`` (none).

    A number without a unit has that of the signal it is compared with.

    ``f weak_until[a, b] g`` asks for ``f`` at all times of the interval before which ``g`` has not held, now or later: ``g`` ends it even
    if it holds before the interval begins, and need never hold. Before ``a`` and after ``b`` nothing is asked. (It is the dual of
    ``until``: not ``(not g) until[a, b] (not f and not g)``, so that the negation of each is a formula of the language, too. It is not
    ``f until[a, b] g or always[a, b] f``, whose first half asks for ``f`` from now on and for ``g`` within the interval.)

    >>> formula = Formula("always (speed < 0.25)")
    >>> found = formula.judge([0.0, 0.5, 1.0], speed=[0.1, 0.3, 0.2])
    >>> found.verdict, round(found.robustness.value, 9), found.explanation.to_secs
    (<Verdict.VIOLATED: 'violated'>, -0.05, 0.5)
    >>> Formula("always (speed < 0.25 m/s)").judge([0.0, 0.5], speed=[100.0, 200.0], units={"speed": "mm/s"}).verdict.value
    'satisfied'
    >>> Formula("always[0, 10 s] (speed < 0.25)").judge([0.0, 5.0], speed=[0.1, 0.1]).verdict.value    # five seconds are not ten
    'inconclusive'
    """

    __slots__ = ("_formula", "ending", "text", "time")

    def __init__(
        self,
        text: str,
        *,
        parameters: Mapping[str, float] = {},
        time: Literal["discrete", "dense"] = "discrete",
        interpolation: Literal["hold", "linear"] = "hold",
        ending: Ending = "long_enough",
    ) -> None:
        text = _checked.text(text, "text", "a formula", "for example Formula(\"always speed < 2\")")
        given = _checked.mapping(parameters, "parameters", "seconds", "write parameters={\"late\": 2.0}")
        seconds = {name: _checked.number(value, f"the parameter `{name}`") for name, value in given.items()}
        for word, name in ((time, "time"), (interpolation, "interpolation"), (ending, "ending")):
            _checked.text(word, name, "a word", "see help(corroborate.Formula)")
        self._formula = _engine.Formula(text, seconds, time, interpolation, ending)
        self.text, self.time, self.ending = text, time, ending

    @property
    def atoms(self) -> list[str]:
        """The comparisons and propositions of the formula, as they are written."""
        return self._formula.atoms

    def judge(
        self,
        times: Any = None,
        signals: Any = None,
        /,
        *,
        units: Mapping[str, str] = {},
        complete: bool = True,
        time_column: str = "time",
        **columns: Any,
    ) -> Judgement:
        """Judges one trace.

        Args:
            times: seconds, one for each sample, shape ``(samples,)``; or a data frame of pandas or polars (or a mapping of
                columns), whose column ``time_column`` has them.
            signals: a mapping from names to columns, for names that cannot be arguments.
            units: the unit of columns that have one, for example ``{"speed": "mm/s"}``. Robustness is in SI units.
            complete: ``False`` if the trace was cut short: then nothing is said of what came behind.
            time_column: where a data frame has the times.
            columns: one value for each sample, NaN where it is missing. Arrays of ``float64`` and ``bool`` are read where they
                lie; others are converted.

        Raises:
            Problem: a name without a column, units that do not fit, times that are not in order.
        """
        complete = _checked.flag(complete, "complete")
        _checked.text(time_column, "time_column", "the name of a column", "write time_column=\"stamp\"")
        if times is not None and (hasattr(times, "columns") or isinstance(times, Mapping)):
            table = {str(name): times[name] for name in (times.columns if hasattr(times, "columns") else times)}
            if time_column not in table:
                message = f"the data frame has no column `{time_column}` (it has {', '.join(table)})"
                raise Problem("bad-signals", message, remedy="name the column of the times: time_column=...")
            times = table.pop(time_column)
            # A frame may have columns of texts, and many that are not asked for.
            columns = {**self._used(table), **columns}
        if times is None:
            raise Problem("bad-signals", "the times of the samples are missing", remedy="give them in seconds, first")
        if signals is not None:
            columns = {**_checked.mapping(signals, "signals", "columns", "write {\"speed\": [0.1, 0.2]}"), **columns}
        for name in columns:
            _checked.text(name, "the name of a column", "a name", "name columns as the formula does")
        units = _units(units)
        arrays = [_array(name, column) for name, column in columns.items()]
        declared = [(name, units.get(name, ""), array.dtype.char == "?") for name, array in zip(columns, arrays)]
        _known_units(units, columns)
        return _judgement(self._formula.judge(_times(times), declared, arrays, complete))

    def _used(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """The columns whose names stand in the formula."""
        atoms = self._formula.atoms
        used = {name: column for name, column in table.items() if any(name in atom for atom in atoms)}
        if used or not table:
            return used
        message = f"the formula names none of the columns {', '.join(table)}"
        raise Problem("bad-signals", message, remedy="name columns as they are, for example `always speed < 1`")

    def start(self, signals: Union[Mapping[str, Any], Iterable[str]]) -> Monitor:
        """Begins to judge a stream.

        Args:
            signals: names; or names with their units, or with ``bool`` for truth values: ``{"speed": "m/s", "ready": bool}``.
        """
        return Monitor(self, signals)

    def judge_recordings(self, *recordings: PathLike, partial: bool = False, map: Union[PathLike, None] = None) -> RecordingsReport:
        """Judges recordings (MCAP, bags of ROS 1 and 2, CSV, JSON lines, ...); see :func:`monitor`."""
        return monitor(*recordings, formulas=[self], partial=partial, map=map)

    def __repr__(self) -> str:
        return f"Formula({self.text!r}, time={self.time!r}, ending={self.ending!r})"


class Monitor:
    """A formula that judges a stream, sample by sample, in memory that its windows bound.

    >>> monitor = Formula("always (speed < 0.25)").start(["speed"])
    >>> monitor.step(0.0, speed=0.1) is None
    True
    >>> monitor.step(0.5, speed=0.3)
    <Verdict.VIOLATED: 'violated'>
    >>> monitor.finish().explanation.responsible[0].proposition
    'speed < 0.25'
    """

    __slots__ = ("_monitor", "_places", "_values", "formula")

    def __init__(self, formula: Formula, signals: Union[Mapping[str, Any], Iterable[str]]) -> None:
        remedy = "write [\"speed\"], or {\"speed\": \"m/s\"} with units"
        names = signals if isinstance(signals, Mapping) else _checked.several(signals, "signals", "names", remedy)
        for name in names:
            _checked.text(name, "the name of a signal", "a name", remedy)
        given = dict(names) if isinstance(names, Mapping) else dict.fromkeys(names, "")
        declared = [(name, _unit(unit, name), unit is bool) for name, unit in given.items()]
        self.formula = _checked.instance(formula, "formula", Formula, "a Formula", "write Formula(\"always speed < 1\").start([\"speed\"])")
        self._monitor = formula._formula.start(declared)
        self._places = {name: place for place, name in enumerate(given)}
        self._values = [math.nan] * len(declared)

    def step(self, time_secs: float, values: Mapping[str, float] = _UNCHANGED, /, **signals: float) -> Union[Verdict, None]:
        """Takes a sample: the signals that changed, the others keep their last value. Gives the verdict once nothing that comes
        can change it, ``None`` before."""
        changed = signals
        if values is not _UNCHANGED:
            changed = {**_checked.mapping(values, "values", "numbers", "write step(0.1, speed=0.2)"), **signals}
        held = self._values
        now = held.copy()
        for name, value in changed.items():
            try:
                now[self._places[name]] = value
            except KeyError:
                message = f"the monitor has no signal `{name}` (it has {', '.join(self._places)})"
                raise Problem("bad-signals", message, remedy="declare it when the monitor is started") from None
        try:
            verdict = self._monitor.step(time_secs, now)
        except (TypeError, OverflowError):
            # Only now, since a stream is long: which of them is not a number.
            for name, value in [("time_secs", time_secs), *zip(self._places, now)]:
                _checked.number(value, name)
            raise
        # A sample that was refused has changed nothing.
        self._values = now
        return None if verdict is None else Verdict(verdict)

    @property
    def robustness(self) -> Union[Robustness, None]:
        """What the robustness can still become, whatever comes; ``None`` before the first sample."""
        bounds = self._monitor.robustness()
        return None if bounds is None else Robustness(*bounds)

    @property
    def stored(self) -> int:
        """How many values and times are stored: what bounds the memory."""
        return self._monitor.stored()

    def finish(self, *, complete: bool = True) -> Judgement:
        """Ends the stream; ``complete`` is ``False`` if it was cut short."""
        return _judgement(self._monitor.finish(_checked.flag(complete, "complete")))


def _unit(unit: Any, name: str) -> str:
    """The unit of a signal of a stream."""
    if unit is None or unit is bool:
        return ""
    return _checked.text(unit, f"the unit of `{name}`", "a unit, or bool", f"write {{\"{name}\": \"m/s\"}}")


def _units(units: Any) -> Mapping[str, str]:
    """The units of columns."""
    remedy = "write units={\"speed\": \"mm/s\"}"
    given = _checked.mapping(units, "units", "units", remedy)
    return {name: _checked.text(unit, f"the unit of `{name}`", "a unit", remedy) for name, unit in given.items()}


def _row(values: Any, name: str) -> NDArray[Any]:
    """An array of one dimension: a view where there is one, as pandas and polars give the memory of columns without gaps."""
    import numpy as np

    remedy = "give one value for each sample, shape (samples,)"
    try:
        array = np.asarray(values)
    except Exception as error:  # Whatever an object's own conversion raises.
        raise Problem("bad-signals", f"`{name}` is not an array: {error}", remedy=remedy) from None
    if array.ndim == 1:
        return array
    what = f"has the shape {array.shape}" if array.ndim else f"is a single {type(values).__name__}"
    raise Problem("bad-signals", f"`{name}` {what}, and one value is wanted for each sample", remedy=remedy)


def _array(name: str, column: Any) -> NDArray[Any]:
    import numpy as np

    array = _row(column, name)
    if array.dtype.kind == "b" or array.dtype == np.float64:
        return array
    if array.dtype.kind in "iuf":
        return array.astype(np.float64)
    try:
        # Texts that could be read as numbers, dates and complex numbers are not what is meant by numbers.
        if array.dtype.kind != "O":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        message = f"`{name}`, a column of the type {array.dtype}, is neither numbers nor truth values"
        raise Problem("bad-signals", message, remedy="leave it out, or give numbers for its values") from None


def _times(times: Any) -> NDArray[np.float64]:
    import numpy as np

    array = _row(times, "times")
    if array.dtype.kind in "mM":
        # From the first sample on, in seconds.
        seconds: NDArray[np.float64] = (array - array[:1]) / np.timedelta64(1, "s")
        return seconds
    if array.dtype.kind == "O" and len(array) and all(hasattr(it, "timestamp") for it in array):
        # Dates with a time zone, which NumPy has no type for.
        stamps = np.array([it.timestamp() for it in array], dtype=np.float64)
        return np.asarray(stamps - stamps[0], dtype=np.float64)
    try:
        if array.dtype.kind not in "iufO":
            raise TypeError
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        message = f"times of the type {array.dtype} are not seconds"
        raise Problem("bad-signals", message, remedy="give them as numbers, or as dates (datetime64; pandas.to_datetime reads texts)") from None


def _known_units(units: Mapping[str, str], columns: Mapping[str, Any]) -> None:
    for name in units:
        if name not in columns:
            message = f"`{name}` has a unit, and there is no such column (these are {', '.join(columns)})"
            raise Problem("bad-signals", message, remedy="correct the name")


def _judgement(found: Any) -> Judgement:
    verdict, bounds, covered, samples, decided_at, explanation, ends_before, left_out = found
    if explanation is not None:
        begins, ends, parts = explanation
        responsible = tuple(Responsible(text, value, since, until, tuple(reads)) for text, value, since, until, reads in parts)
        explanation = Explanation(begins, ends, responsible)
    robustness = None if bounds is None else Robustness(*bounds)
    return Judgement(Verdict(verdict), robustness, covered, samples, decided_at, explanation, ends_before, left_out)


@dataclass(frozen=True)
class RecordingJudgement:
    """What one monitor says of one recording."""

    file: str
    subject: str
    """The requirement, the failure mode, or the formula."""
    reading: Union[str, None]
    """Which of several readings, if it is not the main one."""
    verdict: Verdict
    covered: int
    """How often the precondition was met."""
    passed: int
    failed: int
    robustness: Union[Robustness, None]
    no_robustness: Union[str, None]
    """Why there is none."""
    decided_at_secs: Union[float, None]
    explanation: Union[Explanation, None]
    complete: bool
    """Whether the recording was recorded to its end and all of it was read."""
    ends_before: Union[str, None] = None
    """As of :class:`Judgement`."""
    left_out: Union[str, None] = None
    """As of :class:`Judgement`."""


@dataclass(frozen=True)
class RecordingsReport:
    """Recordings that were judged."""

    judgements: tuple[RecordingJudgement, ...]
    """One for each monitor and recording."""
    warnings: tuple[str, ...]
    """What has a meaning that is perhaps not meant."""
    data: Mapping[str, Any]
    """The whole report, as ``corroborate monitor --format json`` prints it."""

    def of(self, subject: str) -> list[RecordingJudgement]:
        """Those of one requirement, failure mode or formula."""
        return [it for it in self.judgements if it.subject == subject]


def monitor(
    *recordings: PathLike,
    formulas: Sequence[Union[Formula, str]] = (),
    study: Union[PathLike, None] = None,
    only: Sequence[str] = (),
    map: Union[PathLike, None] = None,
    partial: bool = False,
    progress: Union[Callable[[dict[str, Any]], object], None] = None,
) -> RecordingsReport:
    """Judges recordings, or folders of them, by formulas or by the monitors of a study.

    Args:
        recordings: files in any format that ``corroborate monitor`` reads (MCAP, bags of ROS 1 and 2, CSV, JSON lines, ...).
        formulas: formulas over signals ``/topic.field``, all of one ``time`` and ``ending``.
        study: the folder of a study, whose requirements and failure modes are judged.
        only: of these only the ones with these identifiers.
        map: a topic map, which says where recordings have the signals; by default the study's.
        partial: judges recordings that are not complete as far as they go.
        progress: called with each event, a dictionary.
    """
    given = _checked.several(formulas, "formulas", "formulas", "write formulas=[\"always /robot.speed < 1\"]")
    read = [it if isinstance(it, Formula) else Formula(it) for it in given]
    progress = _checked.optional_callback(progress, "progress")
    kinds = {(it.time, it.ending) for it in read} or {("discrete", "long_enough")}
    if len(kinds) > 1:
        raise Problem("bad-setting", "the formulas differ in `time` or `ending`", remedy="judge them one after another")
    ((time, ending),) = kinds
    remedy = "write only=[\"1\"]"
    asked = {
        "recordings": [_checked.path(path, "a recording", "a recording", "name its file") for path in recordings],
        "study": None if study is None else _checked.path(study, "study", "a study's folder", "name the folder that holds study.toml"),
        "only": [_checked.text(it, "an entry of only", "an identifier", remedy) for it in _checked.several(only, "only", "identifiers", remedy)],
        "formulas": [it._formula.written_out for it in read],
        "ending": ending,
        "time": time,
        "map": None if map is None else _checked.path(map, "map", "a topic map", "name its file"),
        "partial": _checked.flag(partial, "partial"),
    }
    if not recordings:
        raise Problem("wrong-argument", "no recording is named, so that nothing is judged", remedy="write monitor(\"run.mcap\", formulas=[...])")
    if not read and study is None:
        message = "neither formulas nor a study are given, so that nothing is judged"
        raise Problem("wrong-argument", message, remedy="write formulas=[\"always /robot.speed < 1\"], or study=FOLDER")
    report = _engine.monitor_recordings(asked, progress)
    judged = (_recording(it, verdict) for it in report["recordings"] for verdict in it["verdicts"])
    return RecordingsReport(tuple(judged), tuple(report["warnings"]), report)


def _recording(recording: Mapping[str, Any], found: Mapping[str, Any]) -> RecordingJudgement:
    bounds, violation = found["robustness"], found["violation"]
    if bounds is not None:
        least, greatest = bounds["least"], bounds["greatest"]
        bounds = Robustness(-math.inf if least is None else least, math.inf if greatest is None else greatest)
    if violation is not None:
        parts = (
            Responsible(it["proposition"], it["value"], it["from_secs"], it["to_secs"], tuple(signal["name"] for signal in it["signals"]))
            for it in violation["responsible"]
        )
        violation = Explanation(violation["from_secs"], violation["to_secs"], tuple(parts))
    return RecordingJudgement(
        recording["file"],
        found["subject"],
        found["reading"],
        Verdict(found["verdict"].replace("_", "-")),
        found["covered"],
        found["passed"],
        found["failed"],
        bounds,
        found["no_robustness"],
        found["decided_at_secs"],
        violation,
        recording["complete"],
        found["ends_before"],
        found["left_out"],
    )

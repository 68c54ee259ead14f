"""Models of the PRISM language: built, inspected, checked."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Union, overload

from . import _checked, _engine
from ._answers import Answer, Witness
from ._functions import parametric
from ._problem import Problem, WrongArgument
from ._space import StateSpace

if TYPE_CHECKING:
    from stormvogel.model import Model as StormvogelModel

__all__ = ["Constant", "Decision", "Model", "Scheduler"]

Constants = Mapping[str, Any]


@dataclass(frozen=True)
class Constant:
    """A constant that a model declares."""

    name: str
    type: str
    """``int``, ``double`` or ``bool``."""
    value: Union[str, None]
    """The text of its value; ``None`` if it has to be given one."""


@dataclass(frozen=True)
class Decision:
    """What a scheduler does in a state."""

    state: Mapping[str, int]
    """The values of the variables; a truth value is 0 or 1."""
    memory: Union[int, None]
    choice: int
    """The place of the choice among the state's, from 0."""
    action: Union[str, None]
    share: Fraction
    """How likely it is taken."""


@dataclass(frozen=True)
class Scheduler:
    """What attains an answer: decisions where they matter."""

    memory: Union[str, None]
    """What the memory says: ``steps`` (how many were taken), ``automaton`` or ``mixture``; ``None`` where the state is enough."""
    decisions: tuple[Decision, ...]


class Model:
    """A model: of the PRISM language, or states and transitions in explicit files.

    >>> model = Model.parse('''
    ... dtmc
    ... const double p;
    ... module robot
    ...   s : [0..2] init 0;  // 0 trying, 1 grasped, 2 dropped
    ...   [] s=0 -> p:(s'=1) + 0.01:(s'=2) + 0.99-p:(s'=0);
    ... endmodule
    ... label "grasped" = s=1;
    ... ''')
    >>> model.check('P=? [ F "grasped" ]', constants={"p": 0.9}, method="exact").value
    Fraction(90, 91)
    >>> model.check('P=? [ F "grasped" ]', open={"p": (0.5, 0.9)}).parametric(p=0.9)
    Fraction(90, 91)
    >>> len(model.build(constants={"p": 0.9}))
    3
    """

    __slots__ = ("_model",)
    _model: _engine.Model

    def __init__(self, *_: object) -> None:
        raise TypeError("a model is read by Model.parse(text), Model.load(path) or Model.from_stormvogel(model)")

    @classmethod
    def _of(cls, model: _engine.Model) -> Model:
        made = object.__new__(cls)
        made._model = model
        return made

    @classmethod
    def parse(cls, text: str, *, name: str = "<model>") -> Model:
        """Reads a text in the PRISM language; ``name`` is what messages call it by.

        Raises:
            Problem: at the place of the first mistake, with all others as ``related``.
        """
        text = _checked.text(text, "text", "a model in the PRISM language", "Model.load(path) reads a file")
        return cls._of(_engine.Model.parse(text, _checked.text(name, "name", "a name", "write name=\"gripper.prism\"")))

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> Model:
        """Reads a file in the PRISM language, or an explicit one: ``FILE.tra``, ``FILE.tra,sta,lab``, ``FILE.all``, ``FILE.drn``."""
        return cls._of(_engine.Model.load(_checked.path(path, "path", "a model's file", "Model.parse(text) reads a text")))

    @classmethod
    def from_stormvogel(cls, model: StormvogelModel) -> Model:
        """A stormvogel model (``dtmc``, ``ctmc`` or ``mdp``) with its labels, valuations and rewards."""
        from . import _stormvogel

        if not all(hasattr(model, part) for part in ("get_type", "states", "transitions", "rewards")):
            message = f"model is a model of stormvogel 0.1, not {type(model).__name__}"
            raise WrongArgument("wrong-argument", message, remedy="make one with stormvogel.model.new_dtmc() and such; Model.parse reads a text")
        return cls.parse(_stormvogel.to_prism(model), name="<stormvogel>")

    def to_stormvogel(self, *, constants: Constants = {}) -> StormvogelModel:
        """The states as a stormvogel model (which must be installed)."""
        return self.build(constants=constants).to_stormvogel()

    @property
    def name(self) -> str:
        """What messages call it by: the path, for a file."""
        return self._model.name

    @property
    def text(self) -> Union[str, None]:
        """Its text; ``None`` of an explicit file."""
        return self._model.text

    @property
    def kind(self) -> Union[str, None]:
        """``dtmc``, ``ctmc``, ``mdp``, ...; ``None`` where the text has no keyword."""
        return self._model.kind

    @property
    def constants(self) -> dict[str, Constant]:
        """The constants that it declares, by name."""
        return {name: Constant(name, kind, value) for name, kind, value in self._model.constants}

    @property
    def modules(self) -> list[str]:
        """The names of its modules."""
        return self._model.modules

    @property
    def labels(self) -> list[str]:
        """The names of its labels."""
        return self._model.labels

    @property
    def rewards(self) -> list[Union[str, None]]:
        """The names of its reward structures; ``None`` of one without a name."""
        return self._model.rewards

    @overload
    def check(
        self,
        property: str,
        /,
        *,
        constants: Constants = {},
        method: str = "sound",
        precision: float = 1e-6,
        open: Mapping[str, tuple[Any, Any]] = {},
        witness: bool = False,
        certify: bool = False,
        fair: bool = False,
        max_states: Union[int, None] = None,
        timeout: Union[float, None] = None,
    ) -> Answer: ...
    @overload
    def check(
        self,
        property: Union[list[str], tuple[str, ...], os.PathLike[str]],
        /,
        *,
        constants: Constants = {},
        method: str = "sound",
        precision: float = 1e-6,
        open: Mapping[str, tuple[Any, Any]] = {},
        witness: bool = False,
        certify: bool = False,
        fair: bool = False,
        max_states: Union[int, None] = None,
        timeout: Union[float, None] = None,
    ) -> list[Answer]: ...
    def check(
        self,
        property: Union[str, list[str], tuple[str, ...], os.PathLike[str]],
        /,
        *,
        constants: Constants = {},
        method: str = "sound",
        precision: float = 1e-6,
        open: Mapping[str, tuple[Any, Any]] = {},
        witness: bool = False,
        certify: bool = False,
        fair: bool = False,
        max_states: Union[int, None] = None,
        timeout: Union[float, None] = None,
    ) -> Union[Answer, list[Answer]]:
        """Answers one property (one :class:`Answer`), or several over the same states (a list): texts, or a path to a file.

        Args:
            property: in the PRISM language, for example ``P=? [ F "done" ]``.
            constants: values of constants; a float is taken for the decimal number that it prints as. A ``range``, or
                ``(first, step, last)``, asks for each value: the answer is then a list, each with its ``constants``.
            method: ``sound`` (bounds that hold, rounding included), ``exact`` (fractions), or another of
                ``corroborate check --help``.
            precision: relative width of the bounds.
            open: constants that stay open, each with its range: the answer's ``parametric`` has functions of them.
            witness: finds the most probable path that shows why.
            certify: checks each answer again with code that shares nothing with the solver.
            fair: only fair schedulers.
            max_states: more states than this are refused.
            timeout: seconds, after which the answer has the bounds that were reached.

        Raises:
            Problem: what is wrong with model, constants or property, at its place; what is not supported; a limit that ended
                the work before there were bounds.
        """
        is_one, is_file = isinstance(property, str), isinstance(property, os.PathLike)
        asked = {
            "properties": [] if is_file else _properties(property),
            "files": [_checked.path(property, "property", "a file of properties", "name its file")] if is_file else [],
            "constants": _constants(constants),
            "open": _open(open),
            "method": _method(method),
            "precision": _precision(precision),
            "max_states": None if max_states is None else _checked.whole(max_states, "max_states"),
            "timeout_secs": None if timeout is None else _checked.number(timeout, "timeout"),
            "witness": _checked.flag(witness, "witness"),
            "certify": _checked.flag(certify, "certify"),
            "fair": _checked.flag(fair, "fair"),
            "scheduler": False,
        }
        report, _ = self._model.check(asked)
        answers = [_answer(found) for found in report["properties"]]
        return answers[0] if is_one and len(answers) == 1 else answers

    def scheduler(self, property: str, /, *, constants: Constants = {}, method: str = "sound", fair: bool = False) -> Scheduler:
        """The scheduler that attains the answer to a property such as ``Pmax=? [ F "done" ]``, with the memory it needs."""
        asked = {
            "properties": [_property(property, "property", "for example Pmax=? [ F \"done\" ]")],
            "files": [],
            "constants": _constants(constants),
            "open": None,
            "method": _method(method),
            "precision": 1e-6,
            "max_states": None,
            "timeout_secs": None,
            "witness": False,
            "certify": False,
            "fair": _checked.flag(fair, "fair"),
            "scheduler": True,
        }
        report, written = self._model.check(asked)
        _answer(report["properties"][0])
        if written is None:
            raise Problem("no-scheduler", f"there is no scheduler for {property}", remedy="ask for an optimum, as Pmax=? [ F x=1 ]")
        found = json.loads(written)
        decisions = [
            Decision(
                dict(zip(found["variables"], it["state"])),
                it["memory"],
                it["choice"],
                it["action"],
                Fraction(it["share"] or 1),
            )
            for it in found["decisions"]
        ]
        return Scheduler(found["memory"], tuple(decisions))

    def build(self, *, constants: Constants = {}, max_states: int = 100_000_000) -> StateSpace:
        """The reachable states, with transitions, labels, rewards and valuations as arrays."""
        return StateSpace(self._model.build(_constants(constants), _checked.whole(max_states, "max_states")))

    def __repr__(self) -> str:
        return f"<Model {self.name}: {self.kind or 'no type'}, modules {', '.join(self.modules) or 'none'}>"


def _properties(property: Any) -> list[str]:
    """One text, or several."""
    remedy = "for example P=? [ F \"done\" ], or a pathlib.Path of a file of properties"
    if isinstance(property, str):
        return [_property(property, "property", remedy)]
    found = _checked.several(property, "property", "texts, one text or the path of a file", remedy)
    if not found:
        raise Problem("wrong-argument", "property is an empty list, so that nothing is asked", remedy=remedy)
    return [_property(it, f"property[{place}]", remedy) for place, it in enumerate(found)]


def _property(property: Any, name: str, remedy: str) -> str:
    """One text that asks something."""
    found = _checked.text(property, name, "a property", remedy)
    if found.strip():
        return found
    raise Problem("wrong-argument", f"{name} is an empty text, so that nothing is asked", remedy=remedy)


def _precision(precision: Any) -> float:
    found = _checked.number(precision, "precision")
    if 0 < found < 1:
        return found
    raise Problem("bad-setting", f"precision must be between 0 and 1 (got {found})", remedy="give a relative width, for example 1e-6")


def _method(method: Any) -> str:
    return _checked.text(method, "method", "a name", "for example \"sound\" or \"exact\"")


def _open(ranges: Any) -> Union[str, None]:
    """Open constants with their ranges, as the engine reads them."""
    parts = []
    for name, ends in _checked.mapping(ranges, "open", "ranges", "write open={\"p\": (0.5, 0.9)}").items():
        remedy = f"write open={{\"{name}\": (0.5, 0.9)}}"
        found = _checked.several(ends, f"the range of `{name}`", "two numbers", remedy)
        if len(found) != 2:
            raise Problem("wrong-argument", f"the range of `{name}` has {len(found)} numbers, not a lower and an upper one", remedy=remedy)
        parts.append(f"{name}={_number(name, found[0])}:{_number(name, found[1])}")
    return ",".join(parts) or None


def _constants(constants: Constants) -> str:
    parts = []
    for name, value in _checked.mapping(constants, "constants", "values", "write constants={\"p\": 0.9}").items():
        if isinstance(value, range):
            value = (value.start, value.step, value[-1] if len(value) else value.start)
        numbers = value if isinstance(value, tuple) else (value,)
        parts.append(f"{name}={':'.join(_number(name, it) for it in numbers)}")
    return ",".join(parts)


def _number(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _checked.text(value, f"the value of `{name}`", "a number", "give a number, for example 0.9")
    if isinstance(value, (int, Fraction)):
        try:
            return str(value)
        except ValueError:
            message = f"the value of `{name}` has more digits than Python writes"
            raise Problem("bad-constants", message, remedy="give a number of at most 4300 digits") from None
    number = value if isinstance(value, float) else _checked.number(value, f"the value of `{name}`")
    if isinstance(value, float) or not number.is_integer() or "int" not in type(value).__name__:
        if number != number or number in (float("inf"), float("-inf")):
            raise Problem("bad-constants", f"`{name}` must be a finite number (got {value})", remedy="give it a number")
        return repr(number)
    return str(int(value))


def _value(found: Mapping[str, Any]) -> Any:
    text = found["result"]
    if text in ("true", "false"):
        return text == "true"
    if text is None or text.startswith("["):
        return None
    if found["exact"] and text not in ("Infinity", "-Infinity", "NaN"):
        try:
            return Fraction(text)
        except ValueError:
            return None
    return found["value"] if found["value"] is not None else _special(text)


_CANNOT = "correct the property, the constants or the setting that the message names"


def _special(text: str) -> Union[float, None]:
    return {"Infinity": float("inf"), "-Infinity": float("-inf"), "NaN": float("nan")}.get(text)


def _answer(found: Mapping[str, Any]) -> Answer:
    if found["error"] is not None:
        code = "unsupported" if found["unsupported"] else "cannot-check"
        message = f"{found['property']}: {found['error']}"
        raise Problem(code, message, remedy="`corroborate explain sound` says what is answered how" if found["unsupported"] else _CANNOT)
    if found["unfinished"] is not None and found["low"] is None:
        message = f"{found['property']}: a limit ended the work before there were bounds"
        raise Problem("time-limit", message, remedy="give it more time, or a smaller model", kind="undecided")
    value = None if found["parametric"] else _value(found)
    is_number = value is not None and not isinstance(value, bool)
    lower, upper = (value, value) if found["exact"] and is_number else (found["low"], found["high"])
    witness = found["witness"]
    constants = [part.split("=") for part in (found["constants"] or "").split(",") if part]
    return Answer(
        property=found["property"],
        value=value,
        lower=lower,
        upper=upper,
        guarantee=found["guarantee"] or "bounded",
        text=found["result"] or f"[{lower},{upper}]",
        method=found["method"],
        name=found["name"],
        constants={name: _constant(text) for name, text in constants},
        complement=found["complement"],
        iterations=found["iterations"],
        seconds=found["check_secs"],
        notes=tuple(found["notes"]),
        states={it["values"]: it["result"] for it in found["printed"]},
        witness=witness and Witness(witness["violates"], witness["probability"], tuple(witness["states"]), tuple(witness["actions"])),
        parametric=parametric(found["parametric"]) if found["parametric"] else None,
        unfinished=found["unfinished"],
        certificate=found["certificate"],
    )


def _constant(text: str) -> Any:
    return text == "true" if text in ("true", "false") else Fraction(text)

"""Corroborate: the same requirements of a robot asked of models, simulations and experiments, and whether the answers agree.

==================  =====================================================
:class:`Model`      models of the PRISM language, built and checked
:class:`Formula`    temporal logic over arrays, data frames and streams
:func:`monitor`     recordings judged by formulas or a study's monitors
:class:`Study`      studies run, compared, plotted, replayed
:mod:`rig`          a simulator in Python as a rig of a study
:func:`requirement` a test that is repeated until its rate is decided
:mod:`stats`        statistics of counted trials
:class:`Problem`    the one exception for wrong input
==================  =====================================================

Whatever is wrong with what a function is given, it raises :class:`Problem`; for an argument of the wrong type it is a
:class:`WrongArgument`, which is a ``TypeError``, too. Only a call that does not fit the signature is Python's own ``TypeError``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._problem import InternalError, Problem, UnknownColumn, WrongArgument

if TYPE_CHECKING:
    from . import rig, stats
    from ._answers import Answer
    from ._formulas import Formula, Monitor, Verdict, monitor
    from ._models import Model, Scheduler
    from ._space import StateSpace
    from ._studies import Study, StudyResult
    from ._table import Table
    from ._tests import requirement

    __version__: str

# Each is loaded when it is first used: importing the package takes a few milliseconds.
_HOMES = {
    "Answer": "_answers",
    "Formula": "_formulas",
    "Model": "_models",
    "Monitor": "_formulas",
    "Scheduler": "_models",
    "StateSpace": "_space",
    "Study": "_studies",
    "StudyResult": "_studies",
    "Table": "_table",
    "Verdict": "_formulas",
    "monitor": "_formulas",
    "requirement": "_tests",
    "rig": "rig",
    "stats": "stats",
}

__all__ = ["InternalError", "Problem", "UnknownColumn", "WrongArgument", *_HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from ._engine import version

        return version()
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f".{home}", __name__)
    value = module if home == name else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

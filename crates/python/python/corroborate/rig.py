"""A rig in Python: a class with ``reset(seed, stimulus)`` and ``step()`` that simulates episodes, as any other rig of a study.

A program that serves it is named in the study's ledger, and is then run, judged, explored, shrunk and calibrated like a built-in
simulation:

.. code-block:: python

    from corroborate import rig

    class Cart:
        signals = {"/cart.gap": "m", "/cart.speed": "m/s"}

        def reset(self, seed, stimulus):
            self.random = stimulus.draws("cart")      # from the seed: the same seed, the same bytes
            self.time, self.gap, self.speed = 0.0, stimulus.number("cart.gap"), 1.5

        def step(self):
            self.time, self.gap = self.time + 0.01, self.gap - 0.01 * self.speed
            return self.time, (self.gap, self.speed)  # a sample; None when the episode is over

    rig.serve(Cart)

The ledger's entry:

.. code-block:: toml

    [[evidence]]
    technique = "simulation"
    command = ["python3", "cart.py"]
    persistent = true
    stimulus = "stimulus.toml"
    leaves = "csv"

It is a program that the study names, which runs once you have allowed it: ``Study(folder, trust=True)``, or ``corroborate trust``.

An environment of Gymnasium is a rig as it is: ``rig.serve(rig.of_gymnasium(make_environment, policy, step_secs=0.02))``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Protocol, Union

from . import _checked
from ._problem import Problem, WrongArgument
from ._rig_protocol import Cell, Episode, Recording, main

__all__ = ["Rig", "Sample", "Stimulus", "episode", "of_gymnasium", "serve"]

Stimulus = Episode
"""What an episode is given: ``seed``, ``test``, ``actions``, ``settings``; ``number(key)``, and ``draws(purpose)`` for what is random."""

Sample = tuple[float, Sequence[Cell]]
"""The time in seconds, and a value for each signal in their order; ``None`` for one that has no sample now."""


class Rig(Protocol):
    """What simulates episodes."""

    @property
    def signals(self) -> Mapping[str, str]:
        """The signals, ``/topic.field``, each with its unit ("" for none)."""

    def reset(self, seed: int, stimulus: Stimulus) -> Optional[Sample]:
        """Begins an episode; may give its first sample. All that is random comes from the seed."""

    def step(self) -> Optional[Sample]:
        """Goes on to the next sample; ``None`` if the episode is over."""


def episode(rig: Union[Rig, Callable[[], Rig]], stimulus: Stimulus, *, most_steps: int = 10_000_000) -> Recording:
    """The recording of one episode; a class, or what makes a rig, is called for a new one."""
    most_steps = _checked.whole(most_steps, "most_steps")
    made = _made(rig)
    remedy = "give a rig.Stimulus, for example rig.Stimulus(seed=1, test=\"drive\")"
    stimulus = _checked.instance(stimulus, "stimulus", Episode, "a Stimulus", remedy)
    recording = Recording(made.signals)
    first = made.reset(stimulus.seed, stimulus)
    if first is not None:
        recording.row(first[0], *first[1])
    for _ in range(most_steps):
        sample = made.step()
        if sample is None:
            return recording
        recording.row(sample[0], *sample[1])
    message = f"the episode of seed {stimulus.seed} is not over after {most_steps} steps"
    raise Problem("bad-rig", message, remedy="let `step` give None when it is over, or raise `most_steps`")


def _made(rig: Any) -> Rig:
    made: Rig = rig() if callable(rig) else rig
    missing = [name for name in ("signals", "reset", "step") if not hasattr(made, name)]
    if missing:
        message = f"rig is a class or object with `signals`, `reset` and `step`, and {type(made).__name__} has no `{missing[0]}`"
        raise WrongArgument("wrong-argument", message, remedy="see help(corroborate.rig)")
    signals = _checked.mapping(made.signals, "signals", "units", "write signals = {\"/cart.speed\": \"m/s\"}")
    for name, unit in signals.items():
        _checked.text(unit, f"the unit of `{name}`", "a unit", "write \"\" for none")
    return made


def serve(rig: Union[Rig, Callable[[], Rig]], arguments: Optional[Sequence[str]] = None) -> None:
    """Serves a rig to Corroborate: the whole program that a ledger's ``command`` names. A class is instantiated anew for each
    episode, so that no episode can depend on the one before."""
    main(lambda stimulus: episode(rig, stimulus), arguments)


class _Environment:
    """An environment of Gymnasium, with a policy."""

    def __init__(self, make: Callable[[], Any], policy: Optional[Callable[[Any], Any]], step_secs: float) -> None:
        self._environment, self._policy, self._step_secs = make(), policy, step_secs
        count = math.prod(self._environment.observation_space.shape)
        names = [f"/observation.value_{place}" for place in range(count)]
        self.signals = {name: "" for name in [*names, "/reward.value", "/reward.total", "/end.terminated", "/end.truncated"]}

    def reset(self, seed: int, stimulus: Stimulus) -> Optional[Sample]:
        # Gymnasium takes seeds that NumPy takes; its spaces draw from seeds of 32 bits.
        self._environment.action_space.seed(seed % 2**32)
        options = {key.removeprefix("reset."): value for key, value in stimulus.settings.items() if key.startswith("reset.")}
        self._observation, _ = self._environment.reset(seed=seed, options=options or None)
        self._number, self._total, self._over = itertools.count(1), 0.0, False
        return 0.0, (*self._numbers(), None, None, None, None)

    def step(self) -> Optional[Sample]:
        if self._over:
            return None
        action = self._environment.action_space.sample() if self._policy is None else self._policy(self._observation)
        self._observation, reward, terminated, truncated, _ = self._environment.step(action)
        self._total, self._over = self._total + float(reward), bool(terminated or truncated)
        return next(self._number) * self._step_secs, (*self._numbers(), float(reward), self._total, bool(terminated), bool(truncated))

    def _numbers(self) -> list[float]:
        import numpy

        numbers: list[float] = numpy.ravel(self._observation).astype(float).tolist()
        return numbers


def of_gymnasium(make: Callable[[], Any], policy: Optional[Callable[[Any], Any]] = None, *, step_secs: float) -> Callable[[], Rig]:
    """An environment of Gymnasium with a policy as a rig: ``make`` makes the environment, ``policy`` gives the action for an
    observation (random actions without one). Observations are arrays (a ``Box``, ``Discrete``); recorded are
    ``/observation.value_0`` and so on, ``/reward.value``, ``/reward.total``, ``/end.terminated``, ``/end.truncated``. Settings
    ``reset.KEY`` of the stimulus go to the options of ``reset``. (``integrations/gymnasium`` names observations, and takes
    environments by name.)"""
    for name, value in (("make", make), ("policy", policy)):
        if _checked.optional_callback(value, name) is None and name == "make":
            raise WrongArgument("wrong-argument", "make is a function that makes the environment, not None", remedy="write lambda: gymnasium.make(...)")
    seconds = _checked.number(step_secs, "step_secs")
    return lambda: _Environment(make, policy, seconds)

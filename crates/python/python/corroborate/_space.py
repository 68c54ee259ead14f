"""The states of a model as arrays."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Union

from . import _checked, _engine
from ._problem import Problem

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Matrix", "Path", "Rewards", "StateSpace"]


_MOST_STEPS = 100_000_000


class Matrix(NamedTuple):
    """A sparse matrix in compressed rows: row ``r`` has the entries ``indptr[r]`` to ``indptr[r + 1]``."""

    data: NDArray[np.float64]
    """Probabilities (rates in a ``ctmc``), one for each entry."""
    indices: NDArray[np.int64]
    """The target state of each entry."""
    indptr: NDArray[np.int64]
    """Where each row starts, one more than there are rows."""

    def to_scipy(self) -> Any:
        """As ``scipy.sparse.csr_array``, without copying the numbers."""
        csr_array = _checked.needed("scipy", "to_scipy", module="scipy.sparse").csr_array
        rows = len(self.indptr) - 1
        columns = max(rows, int(self.indices.max()) + 1 if len(self.indices) else 0)
        return csr_array((self.data, self.indices, self.indptr), shape=(rows, columns))


class Rewards(NamedTuple):
    """A reward structure."""

    state: NDArray[np.float64]
    """What each state earns: per step, or per unit of time in a ``ctmc``."""
    transition: Union[NDArray[np.float64], None]
    """What each entry of the matrix earns besides; ``None`` if none does."""


class Path(NamedTuple):
    """A random path."""

    times: NDArray[np.float64]
    """When each state is entered: the number of the step, or the time in units of the model (``ctmc``)."""
    states: NDArray[np.int64]


class StateSpace:
    """The reachable states of a model, numbered breadth-first from the initial states.

    Arrays that are properties are made once and shared, so they cannot be written.

    >>> import corroborate
    >>> model = corroborate.Model.parse("dtmc module m x:[0..2]; [] x=0 -> 0.75:(x'=1) + 0.25:(x'=2); endmodule")
    >>> space = model.build()
    >>> space.valuations["x"].tolist(), space.matrix.data.tolist()
    ([0, 1, 2], [0.75, 0.25, 1.0, 1.0])
    >>> space.path(seed=3).states.tolist()[0]
    0
    """

    def __init__(self, space: _engine.StateSpace) -> None:
        self._space = _checked.instance(space, "space", _engine.StateSpace, "what the engine built", "states are built by Model.build()")

    def __len__(self) -> int:
        """The number of states."""
        return len(self._space)

    @property
    def kind(self) -> str:
        """``dtmc``, ``ctmc`` or ``mdp``."""
        return self._space.kind

    @property
    def num_choices(self) -> int:
        """The number of rows of the matrix: choices, or states of a chain."""
        return self._space.num_choices

    @property
    def num_transitions(self) -> int:
        """The number of entries of the matrix, self-loops of deadlocks included."""
        return self._space.num_transitions

    @property
    def initial(self) -> list[int]:
        """The initial states, ascending."""
        return self._space.initial

    @property
    def deadlocks(self) -> list[int]:
        """States in which no command was enabled, ascending; they were given a self-loop."""
        return self._space.deadlocks

    @cached_property
    def matrix(self) -> Matrix:
        """Transition probabilities or rates: one row for each state of a chain, or for each choice."""
        rows, columns, values, _ = self._space.matrix()
        return Matrix(values, columns, rows)

    @property
    def choice_start(self) -> Union[NDArray[np.int64], None]:
        """Where the choices of each state start among the rows, one entry more than there are states; ``None`` in a chain."""
        return self._space.matrix()[3]

    @cached_property
    def actions(self) -> list[Union[str, None]]:
        """The action of each choice, if it has one; empty in a chain."""
        return self._space.actions()

    @cached_property
    def valuations(self) -> dict[str, NDArray[Any]]:
        """The values of each variable in all states (``int64``, or ``bool``), shape ``(states,)``."""
        found = self._space.valuations()
        for values in found.values():
            values.flags.writeable = False
        return found

    @property
    def labels(self) -> dict[str, NDArray[np.bool_]]:
        """Whether each label holds, in all states; ``init`` and ``deadlock`` are built in."""
        return {name: self._space.label(name) for name in [*self._space.label_names, "init", "deadlock"]}

    def label(self, name: str) -> NDArray[np.bool_]:
        """Whether a label holds, shape ``(states,)``."""
        return self._space.label(_checked.text(name, "name", "a label", "`labels` has them all"))

    @property
    def rewards(self) -> dict[str, Rewards]:
        """The reward structures by name; one without a name is ``""``."""
        names = enumerate(self._space.reward_names)
        return {name or "": Rewards(*self._space.reward(place)) for place, name in names}

    def describe(self, state: int) -> str:
        """A state as ``(name=value,...)``."""
        return self._space.describe(_checked.whole(state, "state"))

    def path(self, *, seed: int, max_steps: int = 1_000) -> Path:
        """A random path of a chain from its first initial state, the same for the same seed; it ends in a state that cannot be
        left, or after ``max_steps`` transitions (at most 100 million, which take 1.6 GB)."""
        found = self._space.path(_checked.whole(seed, "seed"), _checked.whole(max_steps, "max_steps", _MOST_STEPS))
        if found is None:
            message = f"a {self.kind} leaves choices open, so that its paths have no distribution"
            raise Problem("open-choices", message, remedy="sample a dtmc or ctmc, for example the chain of a scheduler")
        return Path(*found)

    def to_stormvogel(self) -> Any:
        """As a stormvogel model (which must be installed)."""
        from . import _stormvogel

        return _stormvogel.from_space(self)

    def __repr__(self) -> str:
        return f"<StateSpace: {self.kind}, {len(self)} states, {self.num_transitions} transitions>"

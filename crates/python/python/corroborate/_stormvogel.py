"""Models of stormvogel (https://github.com/moves-rwth/stormvogel), both ways.

Written against stormvogel 0.1: states, transitions, labels, valuations, rewards and parameters of a ``dtmc``, ``ctmc`` or ``mdp``.
"""

from __future__ import annotations

import re
import warnings
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ._problem import Problem

if TYPE_CHECKING:
    from ._space import StateSpace

__all__ = ["from_space", "to_prism"]

_KINDS = ("dtmc", "ctmc", "mdp")
# What PRISM has for every model.
_BUILT_IN = ("init", "deadlock")


def to_prism(model: Any) -> str:
    """A stormvogel model as text in the PRISM language, with one variable ``state`` and one for each valuation."""
    kind = model.get_type().name.lower()
    if kind not in _KINDS:
        raise Problem("unsupported", f"a stormvogel model of the type {kind} is not supported", remedy="give a dtmc, ctmc or mdp")
    place = {number: at for at, number in enumerate(model.states)}
    variables = _variables(model)
    lines = [kind, *(f"const double {name};" for name in sorted(_parameters(model))), "module stormvogel"]
    start = place[_initial(model).id]
    lines.append(f"  state : [0..{max(len(place) - 1, 1)}] init {start};")
    lines += [f"  {name} : {spelled};" for name, spelled in variables.items()]
    for number, transition in model.transitions.items():
        for action, branch in transition.transition.items():
            targets = (f"{_number(share)}:{_update(model, target, place, variables)}" for share, target in branch.branch)
            lines.append(f"  [{_action(action)}] state={place[number]} -> {' + '.join(targets)};")
    lines += ["endmodule", *_labels(model, place), *_rewards(model, place)]
    return "\n".join(lines) + "\n"


def _initial(model: Any) -> Any:
    found = [state for state in model.states.values() if "init" in state.labels]
    if len(found) != 1:
        raise Problem("unsupported", f"the stormvogel model has {len(found)} states labelled init", remedy="label one state init")
    return found[0]


def _parameters(model: Any) -> set[str]:
    branches = (branch for it in model.transitions.values() for branch in it.transition.values())
    texts = (share for branch in branches for share, _ in branch.branch if isinstance(share, str))
    return {name for text in texts for name in re.findall(r"[A-Za-z_]\w*", text)}


def _variables(model: Any) -> dict[str, str]:
    """Each variable's declaration, of those that all states have as whole numbers or truth values."""
    names = sorted({name for state in model.states.values() for name in state.valuations})
    found = {}
    for name in names:
        values = [state.valuations.get(name) for state in model.states.values()]
        start = _initial(model).valuations.get(name)
        _identifier(name, "variable")
        if all(isinstance(value, bool) for value in values):
            found[name] = f"bool init {str(start).lower()}"
        elif all(isinstance(value, int) for value in values):
            found[name] = f"[{min(values)}..{max(max(values), min(values) + 1)}] init {start}"
        else:
            warnings.warn(f"the valuation {name} is left out: not every state has a whole number or a truth value", stacklevel=4)
    return found


def _update(model: Any, target: Any, place: dict[int, int], variables: dict[str, str]) -> str:
    values = (f"&({name}'={str(target.valuations[name]).lower()})" for name in variables)
    return f"(state'={place[target.id]}){''.join(values)}"


def _number(value: Any) -> str:
    if isinstance(value, str):
        return f"({value})"
    return str(value) if isinstance(value, (int, Fraction)) else repr(float(value))


def _identifier(name: str, what: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*", name):
        raise Problem("unsupported", f"the {what} `{name}` cannot be written in the PRISM language", remedy="give it a name of letters, digits and _")
    return name


def _action(action: Any) -> str:
    return _identifier("_".join(sorted(action.labels)), "action") if action.labels else ""


def _labels(model: Any, place: dict[int, int]) -> list[str]:
    found: dict[str, list[int]] = {}
    for number, state in model.states.items():
        for label in state.labels:
            found.setdefault(label, []).append(place[number])
    names = (name for name in found if name not in _BUILT_IN)
    return [f'label "{_identifier(it, "label")}" = {" | ".join(f"state={at}" for at in found[it])};' for it in names]


def _rewards(model: Any, place: dict[int, int]) -> list[str]:
    lines = []
    for structure in model.rewards:
        lines.append(f'rewards "{_identifier(structure.name, "reward structure")}"')
        for (number, action), value in structure.rewards.items():
            chosen = f"[{_action(action)}] " if model.supports_actions() else ""
            lines.append(f"  {chosen}state={place[number]} : {_number(value)};")
        lines.append("endrewards")
    return lines


def from_space(space: StateSpace) -> Any:
    """The states as a stormvogel model."""
    from . import _checked

    _checked.needed("stormvogel", "to_stormvogel", module="stormvogel.model")
    from stormvogel.model import Branch, EmptyAction, ModelType, Transition, new_model

    model = new_model(ModelType[space.kind.upper()], create_initial_state=False)
    labels, values = space.labels, space.valuations
    states = [
        model.new_state(
            [name for name, held in labels.items() if held[at] and name != "deadlock"],
            {name: column[at].item() for name, column in values.items()},
        )
        for at in range(len(space))
    ]
    matrix, starts = space.matrix, space.choice_start
    of_row: dict[int, Any] = {}
    for at, state in enumerate(states):
        chosen = {}
        for place, row in enumerate(_rows(starts, at)):
            entries = range(matrix.indptr[row], matrix.indptr[row + 1])
            branch = Branch([(matrix.data[it].item(), states[matrix.indices[it]]) for it in entries])
            name = None if starts is None else space.actions[row] or f"choice{place}"
            action = EmptyAction if name is None else model.action(frozenset({name}))
            if action in chosen:
                action = model.action(frozenset({f"{name}_{place}"}))
            chosen[action], of_row[row] = branch, (state.id, action)
        model.set_transitions(state, Transition(chosen))
    _add_rewards(space, model, of_row)
    return model


def _rows(starts: Any, state: int) -> range:
    """The rows of the matrix that are a state's: its choices, or one row in a chain."""
    return range(state, state + 1) if starts is None else range(starts[state], starts[state + 1])


def _add_rewards(space: StateSpace, model: Any, of_row: dict[int, Any]) -> None:
    starts = space.choice_start
    for name, rewards in space.rewards.items():
        if rewards.transition is not None:
            warnings.warn(f"the reward structure {name!r} earns on transitions, which stormvogel does not have: left out", stacklevel=3)
            continue
        structure = model.add_rewards(name or "rewards")
        for row, (number, action) in of_row.items():
            at = row if starts is None else int(starts.searchsorted(row, side="right")) - 1
            structure.rewards[number, action] = rewards.state[at].item()

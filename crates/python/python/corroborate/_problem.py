"""The exceptions of the package."""

from __future__ import annotations

__all__ = ["InternalError", "Problem", "UnknownColumn", "WrongArgument"]


class Problem(ValueError):
    """What is wrong with the input or the call, where, and what to do about it.

    The one exception of this package for wrong input, whatever the input is: a model, a formula, a recording, counts, a
    study, an argument of the wrong kind (:class:`WrongArgument`, which is a ``TypeError``, too), a name that a table does not have
    (:class:`UnknownColumn`, which is a ``KeyError``, too).

    What is not a ``Problem``: a call that does not fit the signature, and an operator between things that do not go together
    (``answer < "much"``, ``bool(answer)`` of a number), are Python's own ``TypeError``; Ctrl-C is ``KeyboardInterrupt``; what a callback
    of yours raises is raised as it is; a mistake of ours is :class:`InternalError`.

    Attributes:
        code: names the kind of problem; ``corroborate explain CODE`` says more.
        message: what is wrong, in one sentence, without its place.
        path: the file as it was given, or for example ``<property>``; ``None`` if the problem has no place.
        line: the line, from 1; ``None`` without a place.
        column: the column in characters, from 1; ``None`` without a place.
        remedy: what to do about it, if that can be said.
        related: further problems of the same input, each a :class:`Problem`.
        kind: ``"input"``, or ``"undecided"`` (a limit of time or memory, or something missing here, kept the work from an
            answer) or ``"data-lost"`` (work was done, but its result could not be kept).

    >>> import corroborate
    >>> try:
    ...     corroborate.Model.parse("dtmc\\nmodule m\\n  x : [0..1;\\nendmodule")
    ... except corroborate.Problem as problem:
    ...     print(problem.path, problem.line)
    <model> 3
    """

    __module__ = "corroborate"

    def __init__(
        self,
        code: str,
        message: str,
        path: str | None = None,
        line: int | None = None,
        column: int | None = None,
        remedy: str | None = None,
        related: list[Problem] | None = None,
        kind: str = "input",
        rendered: str | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.path = path
        self.line = line
        self.column = column
        self.remedy = remedy
        self.related = related or []
        self.kind = kind
        self._rendered = rendered

    def __str__(self) -> str:
        if self._rendered is not None:
            return self._rendered
        remedy = f"\n = help: {self.remedy}" if self.remedy else ""
        return f"error[{self.code}]: {self.message}{remedy}"

    def __reduce__(self) -> tuple[type[Problem], tuple[object, ...]]:
        place = (self.path, self.line, self.column)
        return type(self), (self.code, self.message, *place, self.remedy, self.related, self.kind, self._rendered)


class WrongArgument(Problem, TypeError):
    """A :class:`Problem` whose cause is an argument of the wrong kind: a number where a path is taken, a pair that is none. It is
    a ``TypeError``, too.

    >>> import corroborate
    >>> try:
    ...     corroborate.stats.rate("88", 100)
    ... except corroborate.Problem as problem:
    ...     print(problem.message)
    successes is a whole number, not str
    """

    __module__ = "corroborate"


class UnknownColumn(Problem, KeyError):
    """A :class:`Problem` whose cause is a column that a table does not have. It is a ``KeyError``, too."""

    __module__ = "corroborate"


class InternalError(RuntimeError):
    """A mistake of this package, not of its caller: please report it with what was called."""

    __module__ = "corroborate"

    def __init__(self, said: str) -> None:
        super().__init__(f"this is a mistake in corroborate, not in your input; please report it: {said}")

"""Tables as data frames."""

from __future__ import annotations

from typing import Any

from . import _checked, _engine
from ._problem import UnknownColumn

__all__ = ["Table"]


class Table:
    """Columns of one length. ``polars.DataFrame(table)`` and ``pyarrow.table(table)`` take its memory over without copying (Arrow's
    PyCapsule interface); so does whatever else reads Arrow.
    """

    __slots__ = ("_table",)

    def __init__(self, table: _engine.Table) -> None:
        remedy = "tables are those of StudyResult, `evidence` and `comparisons`"
        self._table = _checked.instance(table, "table", _engine.Table, "what the engine made", remedy)

    def __len__(self) -> int:
        """The number of rows."""
        return len(self._table)

    @property
    def columns(self) -> list[str]:
        """The names of the columns."""
        return self._table.names

    def __getitem__(self, name: str) -> list[Any]:
        """A column as a list, ``None`` where a value is missing.

        Raises:
            UnknownColumn: a :class:`corroborate.Problem` that is a ``KeyError``, too.
        """
        remedy = f"the columns are {', '.join(self.columns)}"
        _checked.text(name, "name", "the name of a column", remedy)
        if name not in self.columns:
            raise UnknownColumn("unknown-column", f"the table has no column `{name}`", remedy=remedy)
        return self._table.column(name)

    def rows(self) -> list[dict[str, Any]]:
        """The rows, each by the names of the columns."""
        columns = {name: self[name] for name in self.columns}
        return [{name: values[row] for name, values in columns.items()} for row in range(len(self))]

    def to_pandas(self) -> Any:
        """As a ``pandas.DataFrame``; its values are copied."""
        pandas = _checked.needed("pandas", "to_pandas")
        return pandas.DataFrame({name: self[name] for name in self.columns})

    def to_polars(self) -> Any:
        """As a ``polars.DataFrame``, over the same memory."""
        polars = _checked.needed("polars", "to_polars")
        return polars.DataFrame(self)

    def to_pyarrow(self) -> Any:
        """As a ``pyarrow.Table``, over the same memory."""
        pyarrow = _checked.needed("pyarrow", "to_pyarrow")
        return pyarrow.table(self)

    def __arrow_c_schema__(self) -> Any:
        return self._table.__arrow_c_schema__()

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self._table.__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"<Table: {len(self)} rows of {', '.join(self.columns)}>"

"""Tables as data frames."""

from __future__ import annotations

from typing import Any

from . import _engine

__all__ = ["Table"]


class Table:
    """Columns of one length. ``polars.DataFrame(table)`` and ``pyarrow.table(table)`` take its memory over without copying (Arrow's
    PyCapsule interface); so does whatever else reads Arrow.
    """

    __slots__ = ("_table",)

    def __init__(self, table: _engine.Table) -> None:
        self._table = table

    def __len__(self) -> int:
        """The number of rows."""
        return len(self._table)

    @property
    def columns(self) -> list[str]:
        """The names of the columns."""
        return self._table.names

    def __getitem__(self, name: str) -> list[Any]:
        """A column as a list, ``None`` where a value is missing."""
        return self._table.column(name)

    def rows(self) -> list[dict[str, Any]]:
        """The rows, each by the names of the columns."""
        columns = {name: self[name] for name in self.columns}
        return [{name: values[row] for name, values in columns.items()} for row in range(len(self))]

    def to_pandas(self) -> Any:
        """As a ``pandas.DataFrame``; its values are copied."""
        import pandas

        return pandas.DataFrame({name: self[name] for name in self.columns})

    def to_polars(self) -> Any:
        """As a ``polars.DataFrame``, over the same memory."""
        import polars

        return polars.DataFrame(self)

    def to_pyarrow(self) -> Any:
        """As a ``pyarrow.Table``, over the same memory."""
        import pyarrow

        return pyarrow.table(self)

    def __arrow_c_schema__(self) -> Any:
        return self._table.__arrow_c_schema__()

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self._table.__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"<Table: {len(self)} rows of {', '.join(self.columns)}>"

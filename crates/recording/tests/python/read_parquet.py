"""Reads the tables of foreign_readers.rs with pyarrow, pandas, polars and DuckDB.

Usage: read_parquet.py FOLDER: each of empty, small and large.parquet has the values computed here.
"""

import json
import math
import sys
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.parquet

ROWS = {"empty": 0, "small": 3, "large": 150_000}
TYPES = {
    "number": "uint64",
    "seed": "uint64",
    "even": "bool",
    "maybe": "bool",
    "third": "double",
    "gaps": "double",
    "name": "string",
    "never": "string",
}


def expected(number: int) -> tuple:
    return (
        number,
        2**64 - 1 - number,
        number % 2 == 0,
        None if number % 3 == 0 else number % 3 == 1,
        number / 3.0,
        -math.inf if number == 0 else None if number % 5 == 4 else -float(number),
        f"näme {number % 7}",
        None,
    )


def check(reader: str, name: str, rows: list[tuple]) -> None:
    wanted = [expected(number) for number in range(ROWS[name])]
    assert len(rows) == len(wanted), f"{reader}: {name} has {len(rows)} rows"
    for number, (row, want) in enumerate(zip(rows, wanted)):
        assert tuple(row) == want, f"{reader}: {name}, row {number}: {row}, expected {want}"
    print(f"{reader} {name} {len(rows)}")


def main() -> None:
    folder = Path(sys.argv[1])
    for name in ROWS:
        path = folder / f"{name}.parquet"
        file = pyarrow.parquet.ParquetFile(path)
        types = {field.name: str(field.type) for field in file.schema_arrow}
        assert types == TYPES, types
        assert file.metadata.metadata[b"study"] == b'a "test"'
        about = json.loads(file.metadata.metadata[b"corroborate.columns"])
        assert about["third"] == {"unit": "m/s"}, about
        assert about["number"] == {"meaning": "the row's number, from 0"}, about
        assert (file.metadata.num_row_groups > 1) == (name == "large")
        check("pyarrow", name, list(zip(*file.read().to_pydict().values())))
        frame = pandas.read_parquet(path, dtype_backend="numpy_nullable")
        columns = ([None if value is pandas.NA else value for value in frame[key]] for key in frame)
        check("pandas", name, list(zip(*columns)))
        check("polars", name, polars.read_parquet(path).rows())
        rows = duckdb.sql(f"SELECT * FROM '{path}'").fetchall()
        check("duckdb", name, rows)
        assert duckdb.sql(f"SELECT count(*) FROM '{path}' WHERE even").fetchall() == [
            ((ROWS[name] + 1) // 2,)
        ]


main()

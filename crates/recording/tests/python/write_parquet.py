"""Writes random tables with pyarrow, pandas, polars and DuckDB, and beside each what is in it, as JSON.

Usage: write_parquet.py FOLDER COUNT SEED: N.parquet, and N.json: of each column its kind and its value in each row, where texts are
lists of texts, and numbers and truth values of lists are numbers.
"""

import json
import random
import sys
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow
import pyarrow.parquet

folder, count, dice = Path(sys.argv[1]), int(sys.argv[2]), random.Random(int(sys.argv[3]))
WORDS = ["", "pick", "place", "näme", "x" * 300]


def some(draw, missing):
    """A drawing of a value that may be missing."""
    return lambda: None if dice.random() < missing else draw()


def columns(rows):
    """Name, kind, Arrow type, values."""
    missing = dice.choice([0, 0, 0.3, 1])
    small = dice.random() < 0.5
    whole = (lambda: dice.randrange(5)) if small else (lambda: dice.randrange(-(2**62), 2**62))
    real = (lambda: dice.choice([0.0, 1.5, -2.25])) if small else (lambda: dice.gauss(0, 1e6))
    share = dice.random()
    draws = {
        "next.success": ("bool", pyarrow.bool_(), lambda: dice.random() < share),
        "short": ("int", pyarrow.int32(), lambda: dice.randrange(-9, 9)),
        "long": ("int", pyarrow.int64(), whole),
        "single": ("double", pyarrow.float32(), lambda: dice.choice([0.5, -3.25, 1e6])),
        "double": ("double", pyarrow.float64(), real),
        "text": ("texts", pyarrow.string(), lambda: dice.choice(WORDS)),
        "tasks": ("texts", pyarrow.list_(pyarrow.string()), lambda: [dice.choice(WORDS) for _ in range(dice.randrange(3))]),
        "stats/max": ("numbers", pyarrow.list_(pyarrow.bool_()), lambda: [dice.random() < 0.5 for _ in range(dice.randrange(3))]),
    }
    for name, (kind, type_, draw) in draws.items():
        draw = some(draw, missing)
        yield name, kind, type_, [draw() for _ in range(rows)]


def write_pyarrow(table, path):
    pyarrow.parquet.write_table(
        table,
        path,
        compression=dice.choice(["none", "snappy", "zstd", "lz4"]),
        data_page_version=dice.choice(["1.0", "2.0"]),
        use_dictionary=dice.random() < 0.5,
        row_group_size=dice.choice([1, 7, 1000, 100_000]) if table.num_rows < 2000 else 9973,
        data_page_size=dice.choice([64, 1000, 2**20]),
        dictionary_pagesize_limit=dice.choice([100, 2**20]),
        write_page_checksum=dice.random() < 0.5,
        version=dice.choice(["1.0", "2.4", "2.6"]),
    )


def write_pandas(table, path):
    table.to_pandas(types_mapper=pandas.ArrowDtype).to_parquet(path)


def write_polars(table, path):
    polars.from_arrow(table).write_parquet(path, compression=dice.choice(["uncompressed", "snappy", "zstd", "lz4"]))


def write_duckdb(drawn, path):
    duckdb.sql(f"COPY (SELECT * FROM drawn) TO '{path}' (FORMAT parquet, CODEC '{dice.choice(['uncompressed', 'snappy', 'zstd'])}')")


def expected(kind, value):
    if kind in ("bool", "int", "double"):
        return value
    values = [] if value is None else [value] if isinstance(value, str) else value
    return [float(it) for it in values] if kind == "numbers" else values


for number in range(count):
    rows = dice.choice([0, 1, 2, 9, 100, 1500, 20_000])
    drawn = list(columns(rows))
    table = pyarrow.table({name: pyarrow.array(values, type_) for name, _, type_, values in drawn})
    path = folder / f"{number}.parquet"
    writer = dice.choice([write_pyarrow, write_pyarrow, write_pyarrow, write_pandas, write_polars, write_duckdb])
    writer(table, path)
    about = {name: {"kind": kind, "values": [expected(kind, it) for it in values]} for name, kind, _, values in drawn}
    path.with_suffix(".json").write_text(json.dumps({"by": writer.__name__, "rows": rows, "columns": about}), "utf-8")

"""Writes the tables of this folder, and beside each what is in it, with pyarrow 26.0.1: python make.py"""

import json
from pathlib import Path

import pyarrow
import pyarrow.parquet

ROWS = 12
COLUMNS = {
    "episode_index": ("int", pyarrow.int64(), [row // 4 for row in range(ROWS)]),
    "short": ("int", pyarrow.int32(), [None if row == 5 else -row for row in range(ROWS)]),
    "next.success": ("bool", pyarrow.bool_(), [row % 5 == 3 for row in range(ROWS)]),
    "tasks": ("texts", pyarrow.list_(pyarrow.string()), [[], None, ["pick"], ["pick", "place"]] * 3),
    "stats/next.success/max": ("numbers", pyarrow.list_(pyarrow.bool_()), [[row > 5] for row in range(ROWS)]),
    "single": ("double", pyarrow.float32(), [row / 4 for row in range(ROWS)]),
}

for name, options in {
    "snappy": {"compression": "snappy"},
    "second_version": {"compression": "zstd", "data_page_version": "2.0"},
    "plain": {"compression": "none", "use_dictionary": False, "row_group_size": 5, "write_page_checksum": True},
    "lz4": {"compression": "lz4", "data_page_size": 16, "dictionary_pagesize_limit": 16},
}.items():
    folder = Path(__file__).parent
    table = pyarrow.table({key: pyarrow.array(values, type_) for key, (_, type_, values) in COLUMNS.items()})
    pyarrow.parquet.write_table(table, folder / f"{name}.parquet", **options)
    listed = lambda kind, it: ([float(x) for x in it] if kind == "numbers" else it or []) if kind in ("texts", "numbers") else it
    about = {key: {"kind": kind, "values": [listed(kind, it) for it in values]} for key, (kind, _, values) in COLUMNS.items()}
    (folder / f"{name}.json").write_text(json.dumps({"by": "pyarrow", "rows": ROWS, "columns": about}) + "\n")

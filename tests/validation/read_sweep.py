"""The table of a sweep as pandas, polars and DuckDB read it, from text and from Parquet: the same numbers.

python tests/validation/read_sweep.py DIR    (DIR holds sweep.csv and sweep.parquet; pip install pandas polars duckdb)
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import duckdb
import numpy as np
import pandas
import polars


def main() -> None:
    folder = Path(sys.argv[1])
    text, parquet = folder / "sweep.csv", folder / "sweep.parquet"
    described = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["columns"]
    numbers = [one["name"] for one in described if one["kind"] != "text"]
    tables = {
        "pandas, text": pandas.read_csv(text),
        "pandas, Parquet": pandas.read_parquet(parquet),
        "polars, text": polars.read_csv(text, infer_schema_length=None).to_pandas(),
        "polars, Parquet": polars.scan_parquet(parquet).collect().to_pandas(),
        "DuckDB, text": duckdb.sql(f"SELECT * FROM read_csv('{text}', sample_size=-1)").df(),
        "DuckDB, Parquet": duckdb.sql(f"SELECT * FROM '{parquet}'").df(),
    }
    first = tables["pandas, Parquet"]
    for name, table in tables.items():
        assert list(table.columns) == [one["name"] for one in described], name
        assert len(table) == len(first), name
        for column in numbers:
            found = table[column].astype(float).to_numpy()
            assert np.array_equal(found, first[column].astype(float).to_numpy(), equal_nan=True), (name, column)
        print(f"{name}: {len(table)} rows, {len(numbers)} columns of numbers equal to the last bit")


if __name__ == "__main__":
    main()

"""The results of ``romano sweep``: tables in plain Python, or as data frames where pandas is installed.

The columns are explained in ``experiments/README.md``, "What it measures"; times in them say their unit (``_s``,
``_ms``).
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from .errors import NoSweep

if TYPE_CHECKING:
    import pandas

Value: TypeAlias = int | float | str | None
"""A field; None: there was nothing to measure."""


class Table:
    """Rows under named columns. A column holds ints, floats or strs, and None where a field is empty."""

    def __init__(self, columns: Mapping[str, list[Value]]) -> None:
        self.columns = dict(columns)

    @classmethod
    def read(cls, path: Path | str) -> Table:
        """A CSV file of a sweep. A last line without its end was cut off while it was written, and is left out.

        Raises NoSweep, OSError.
        """
        try:
            text = Path(path).read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise NoSweep(f"{path}: is no text") from None
        lines = text.splitlines(keepends=True)
        if lines and not lines[-1].endswith("\n"):
            lines.pop()
        rows = list(csv.reader(lines))
        if not rows:
            raise NoSweep(f"{path}: has no line with the columns' names")
        names = rows[0]
        for number, row in enumerate(rows[1:], 2):
            if len(row) != len(names):
                raise NoSweep(f"{path}, row {number}: has {len(row)} fields, and there are {len(names)} columns")
        fields = zip(*rows[1:], strict=True) if len(rows) > 1 else ([] for _ in names)
        return cls({name: _typed(list(column)) for name, column in zip(names, fields, strict=True)})

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), []))

    def __getitem__(self, column: str) -> list[Value]:
        """Raises KeyError."""
        return self.columns[column]

    def __iter__(self) -> Iterator[dict[str, Value]]:
        """Row by row."""
        for values in zip(*self.columns.values(), strict=True):
            yield dict(zip(self.columns, values, strict=True))

    def where(self, **wanted: Value) -> Table:
        """The rows with these values: ``runs.where(status="ok", brokers=3)``. Raises KeyError."""
        kept = [at for at in range(len(self)) if all(self[name][at] == value for name, value in wanted.items())]
        return Table({name: [column[at] for at in kept] for name, column in self.columns.items()})

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame; integers with gaps are ``Int64``. Raises ImportError without pandas."""
        import pandas

        return pandas.DataFrame({name: pandas.Series(v, dtype=_dtype(v)) for name, v in self.columns.items()})


class Sweep:
    """A results folder, such as ``results/demo``. A running sweep's folder can be read too.

    sweep = romano.Sweep("results/demo")
    for run in sweep.runs.where(status="ok"):
        print(run["brokers"], run["delay_p50_ms"])
    frame = sweep.runs.to_pandas()
    """

    def __init__(self, folder: Path | str) -> None:
        """Raises NoSweep."""
        self.folder = Path(folder)
        path = self.folder / "runs.csv"
        if not path.is_file():
            raise NoSweep(f"{self.folder}: is no results folder of romano sweep, for it has no runs.csv")
        self.runs = _in_order(Table.read(path))
        """One row a cell, in the cells' order."""

    @property
    def manifest(self) -> dict[str, Any]:
        """Versions, machine, seeds, the sweep file's text, the command of each cell. Raises NoSweep, OSError."""
        path = self.folder / "manifest.json"
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise NoSweep(f"{path}: {error}") from None
        if not isinstance(found, dict):
            raise NoSweep(f"{path}: is no JSON object")
        return found

    def samples(self, cell: int) -> Table:
        """One row a message and receiver: ``sent_s`` from the start of the load, ``delay_ms``, None when it was lost.
        Raises NoSweep for a cell that was not run."""
        return self._cell_table(cell, "")

    def memory(self, cell: int) -> Table:
        """The resident memory of each broker, once a second. Raises NoSweep for a cell that was not run."""
        return self._cell_table(cell, "-memory")

    def _cell_table(self, cell: int, kind: str) -> Table:
        path = self.folder / "samples" / f"cell-{cell:04}{kind}.csv"
        if not path.is_file():
            raise NoSweep(f"{self.folder}: has no {path.name}; runs.csv lists cells {self.runs['cell']}")
        return Table.read(path)


def _in_order(runs: Table) -> Table:
    """Of a running sweep, rows stand in the order in which runs ended, and the last row of a cell counts."""
    if "cell" not in runs.columns:
        return runs
    last = {cell: at for at, cell in enumerate(runs["cell"])}
    cells = sorted(last, key=lambda cell: cell if isinstance(cell, int) else 0)
    return Table({name: [column[last[cell]] for cell in cells] for name, column in runs.columns.items()})


def _typed(fields: list[str]) -> list[Value]:
    """As numbers, if all that is there are numbers."""
    for number in (int, float):
        try:
            return [number(field) if field else None for field in fields]
        except ValueError:
            continue
    return [field or None for field in fields]


def _dtype(values: list[Value]) -> str:
    present = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in present):
        return "object"
    if not all(isinstance(value, int) for value in present) or not present:
        return "float64"
    return "int64" if len(present) == len(values) else "Int64"

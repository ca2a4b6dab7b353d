"""Files that are readable whenever the program is killed: replaced as a whole, or appended line by line."""

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TextIO


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` (same ending) that takes its place when the block ends without an exception."""
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Writes a whole text file."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


class CsvFile:
    """A table of numbers with a heading, first column time; each row reaches the operating system at once."""

    def __init__(self, path: Path, columns: Sequence[str], resumed_at: float | None):
        """Starts the file anew, or with `resumed_at` keeps its rows up to that time (s)."""
        self.path = path
        self.columns = tuple(columns)
        rows = [] if resumed_at is None else _rows_until(path, resumed_at)
        write_text(path, "".join(line + "\n" for line in [",".join(columns), *rows]))
        self._file: TextIO = path.open("a", encoding="utf-8", newline="\n")

    def append(self, values: Sequence[float]) -> None:
        """Writes one row; numbers read back as the same float64, whole numbers without a decimal point stay so."""
        if len(values) != len(self.columns):
            raise ValueError(f"{self.path.name}: {len(values)} values for {len(self.columns)} columns")
        self._file.write(",".join(_number(value) for value in values) + "\n")
        self._file.flush()

    def close(self) -> None:
        """Ends writing."""
        self._file.close()


def _number(value: float) -> str:
    plain = value.item() if hasattr(value, "item") else value
    return repr(plain)


def _rows_until(path: Path, time: float) -> list[str]:
    """Complete rows of a file whose first column is at most `time`."""
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").split("\n")
    complete = lines[1:-1]  # the last element is what follows the last line break: nothing, or half a row
    return [line for line in complete if float(line.partition(",")[0]) <= time]


def last_time(path: Path) -> float | None:
    """Time of the last complete row; None without one."""
    rows = _rows_until(path, float("inf"))
    return float(rows[-1].partition(",")[0]) if rows else None

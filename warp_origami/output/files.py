"""Files that are readable whenever the program is killed: replaced as a whole, or appended line by line."""

import contextlib
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from warp_origami.errors import InputError


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` (same ending) that takes its place when the block ends without an exception.

    Its content is on the disk before it does, so that the power may fail too. A link that stands in the place of either
    is replaced, never followed.
    """
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    temporary.unlink(missing_ok=True)  # of a killed run, or a link to somewhere else
    try:
        yield temporary
        _sync(temporary)
        os.replace(temporary, path)
        _sync(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Waits until a file, or the names in a folder, are on the disk."""
    if path.is_dir() and not hasattr(os, "O_DIRECTORY"):
        return  # this system keeps names in its own way
    handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_text(path: Path, text: str) -> None:
    """Writes a whole text file."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


class CsvFile:
    """A table of numbers with a heading, first column time; each row reaches the operating system at once."""

    def __init__(self, path: Path, columns: Sequence[str], resumed: bool):
        """Starts the file anew, or goes on with its rows."""
        self.path = path
        self.columns = tuple(columns)
        if not resumed:
            write_text(path, ",".join(columns) + "\n")
        self._file: BinaryIO = path.open("ab", buffering=0)  # nothing of a failed row is left to be written later

    def append(self, values: Sequence[float]) -> None:
        """Writes one row; numbers read back as the same float64, whole numbers without a decimal point stay so.

        Raises:
            OSError: it cannot be written, and no part of it is in the file.
        """
        if len(values) != len(self.columns):
            raise ValueError(f"{self.path.name}: {len(values)} values for {len(self.columns)} columns")
        left = (",".join(_number(value) for value in values) + "\n").encode()
        begin = self._file.tell()
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                self._file.truncate(begin)
            raise OSError(error.errno, error.strerror, str(self.path)) from None

    def sync(self) -> None:
        """Waits until all rows are on the disk."""
        os.fsync(self._file.fileno())

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


def cut_rows(paths: Iterable[Path], time: float) -> None:
    """Keeps the rows of tables up to a time (s); no table is changed unless all of them reach it.

    Raises:
        InputError: a table is missing, damaged, or ends before that time.
    """
    kept = {}
    for path in paths:
        try:
            rows = _rows_until(path, time)
            heading = path.read_text(encoding="utf-8").partition("\n")[0]
            last = float(rows[-1].partition(",")[0]) if rows else None
        except (OSError, ValueError) as error:
            raise InputError("--resume", f"{path} that cannot be read ({error})", "the table as written") from None
        if last != time:
            got = f"{path} without rows" if last is None else f"{path} that ends at {last!r}"
            raise InputError("--resume", got, f"a row at {time!r}, where the checkpoint is")
        kept[path] = "".join(line + "\n" for line in [heading, *rows])
    for path, text in kept.items():
        write_text(path, text)


def last_time(path: Path) -> float | None:
    """Time of the last complete row; None without one, or where it is damaged."""
    try:
        rows = _rows_until(path, float("inf"))
        return float(rows[-1].partition(",")[0]) if rows else None
    except (OSError, ValueError):
        return None

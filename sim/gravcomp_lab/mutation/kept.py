"""A table of verdicts in a CSV file, each with a key of the files that it rests on: it holds while none has changed."""

import csv
import hashlib
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from gravcomp.files import write_atomically


def read_lines(path: Path) -> list[dict[str, str]]:
    """The lines of a table, by column; none where there is no file yet."""
    return list(csv.DictReader(path.read_text().splitlines())) if path.exists() else []


def write_lines(path: Path, columns: Sequence[str], lines: Iterable[Mapping[str, str]]) -> None:
    """Write a table whole."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    write_atomically(path, text.getvalue())


class Keys:
    """Keys of files, each read once; a file that is gone counts as an empty one."""

    def __init__(self):
        self._digests: dict[Path, str] = {}

    def of(self, files: Iterable[Path]) -> str:
        """The key of files, in this order."""
        return hashlib.sha256("".join(map(self._digest, files)).encode()).hexdigest()[:16]

    def _digest(self, file: Path) -> str:
        if file not in self._digests:
            self._digests[file] = hashlib.sha256(file.read_bytes() if file.is_file() else b"").hexdigest()
        return self._digests[file]

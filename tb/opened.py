"""Run commands of gravcomp, JSON on standard input, and print the files that each of them opens as JSON.

What the import of the package opens counts as opened by the first.
"""

import contextlib
import json
import os
import sys
from pathlib import Path

opened: set[str] = set()


def note(event: str, arguments: tuple) -> None:
    if event == "open" and isinstance(arguments[0], str | os.PathLike):
        opened.add(os.fspath(arguments[0]))


def run(command: list[str]) -> list[str]:
    from gravcomp.cli import main

    with contextlib.redirect_stdout(sys.stderr):
        assert main(command) == 0, command
    files = sorted(str(Path(name).resolve()) for name in opened)
    opened.clear()
    return files


if __name__ == "__main__":
    sys.addaudithook(note)
    print(json.dumps([run(command) for command in json.load(sys.stdin)]))

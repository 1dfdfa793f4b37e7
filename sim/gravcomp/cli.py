"""The command line: ``gravcomp <command>``. One module of ``gravcomp.commands`` per command.

Bad input of any kind ends in one line on standard error and exit status 2.
"""

import argparse
import ast
import importlib
import importlib.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from gravcomp import __version__
from gravcomp.errors import InputError

# In the order of the work.
COMMANDS = (
    *("import", "diagnose", "plan", "new", "train", "import-network", "adopt", "formats", "certify"),
    *("rom", "vectors", "image", "board", "loop", "correct", "measure"),
)


class _OneLineParser(argparse.ArgumentParser):
    def error(self, message: str):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: list[str] | None = None) -> int:
    """Run one command of a user; returns the exit status (0, or 2 for bad input)."""
    return run("gravcomp", "Gravity compensation of a robot in an FPGA.", "gravcomp.commands", COMMANDS, argv)


def run(program: str, description: str, package: str, commands: Sequence[str], argv: list[str] | None) -> int:
    """Run one of a program's commands, each a module of package; returns the exit status.

    Only the module of the command that is run is imported: the help of all others is read from their source.
    """
    argv = sys.argv[1:] if argv is None else argv
    chosen = next((word for word in argv if not word.startswith("-")), None)
    parser = _OneLineParser(prog=program, description=description)
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="command")
    for command in commands:
        name = f"{package}.{_module_name(command)}"
        text = _docstring(name)
        subparser = subparsers.add_parser(command, help=text.splitlines()[0], description=text)
        if command == chosen:
            module = importlib.import_module(name)
            module.add_arguments(subparser)
    arguments = parser.parse_args(argv)
    try:
        module.run(arguments)
        sys.stdout.flush()
    except InputError as error:
        print(f"{program} {arguments.command}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader, as `head` does, has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except MemoryError:
        print(f"{program} {arguments.command}: not enough memory; ask for less", file=sys.stderr)
        return 2
    return 0


def _module_name(command: str) -> str:
    return "import_" if command == "import" else command.replace("-", "_")


def _docstring(module: str) -> str:
    """The docstring of a module that is not imported for it."""
    source = Path(importlib.util.find_spec(module).origin).read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(source))

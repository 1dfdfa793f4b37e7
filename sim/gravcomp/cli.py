"""The command line: ``gravcomp <command>``. One module of ``gravcomp.commands`` per command.

Bad input of any kind ends in one line on standard error and exit status 2, Ctrl-C in one and 130.
"""

import argparse
import ast
import importlib
import importlib.util
import io
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from gravcomp import __version__
from gravcomp.errors import InputError

# In the order of the work.
COMMANDS = (
    *("import", "diagnose", "plan", "new", "train", "import-network", "adopt", "formats", "certify"),
    *("rom", "vectors", "image", "board", "campaign", "loop", "correct", "export", "measure"),
)


INTERRUPTED = 130  # exit status of Ctrl-C, as of a shell


class _OneLineParser(argparse.ArgumentParser):
    def error(self, message: str):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def exit(self, status: int = 0, message: str | None = None):
        _flush()  # of a help that nobody can read, here and not at the end of the program
        super().exit(status, message)

    def _print_message(self, message: str, file=None):
        """As argparse does, which hides that a disk is full."""
        print(message, end="", file=file or sys.stderr)


def main(argv: list[str] | None = None) -> int:
    """Run one command of a user; returns the exit status (0, or 2 for bad input)."""
    return run("gravcomp", "Gravity compensation of a robot in an FPGA.", "gravcomp.commands", COMMANDS, argv)


def run(program: str, description: str, package: str, commands: Sequence[str], argv: list[str] | None) -> int:
    """Run one of a program's commands, each a module of package; returns the exit status.

    Only the module of the command that is run is imported: the help of all others is read from their source.
    """
    argv = sys.argv[1:] if argv is None else argv
    chosen = next((word for word in argv if not word.startswith("-")), None)
    where = f"{program} {chosen}" if chosen in commands else program
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # of a file's name, what the terminal has no letter for
    try:
        module, arguments = _parse(program, description, package, commands, argv, chosen)
        module.run(arguments)
        _flush()
    except InputError as error:
        return _refuse(where, str(error))
    except BrokenPipeError:  # the reader, as `head` does, has had enough
        _write_no_more()
    except OSError as error:
        told = error.filename or "standard output"
        try:
            _flush()
        except OSError:
            _write_no_more()
        return _refuse(where, f"{told}: {error.strerror or error}; check the file, its permissions and the disk")
    except MemoryError:
        return _refuse(where, "not enough memory; ask for less")
    except KeyboardInterrupt:
        _refuse(where, "stopped; a file is written whole or not at all")
        return INTERRUPTED
    return 0


def _parse(program, description, package, commands, argv, chosen):
    """The module of the chosen command, and its arguments."""
    parser = _OneLineParser(prog=program, description=description)
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="command")
    module = None
    for command in commands:
        name = f"{package}.{_module_name(command)}"
        text = _docstring(name)
        subparser = subparsers.add_parser(command, help=text.splitlines()[0], description=text)
        if command == chosen:
            module = importlib.import_module(name)
            module.add_arguments(subparser)
    return module, parser.parse_args(argv)


def _refuse(where: str, message: str) -> int:
    print(f"{where}: {message}", file=sys.stderr)
    return 2


def _flush() -> None:
    if sys.stdout:  # closed by the shell it is None
        sys.stdout.flush()


def _write_no_more() -> None:
    """What is still to be written goes nowhere: Python would try once more at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _module_name(command: str) -> str:
    return "import_" if command == "import" else command.replace("-", "_")


def _docstring(module: str) -> str:
    """The docstring of a module that is not imported for it."""
    source = Path(importlib.util.find_spec(module).origin).read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(source))

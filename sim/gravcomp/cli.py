"""The command line: ``gravcomp <command>``. One module of ``gravcomp.commands`` per command.

Bad input of any kind ends in one line on standard error and exit status 2.
"""

import argparse
import importlib
import sys
from collections.abc import Sequence

from gravcomp.errors import InputError

# In the order of the work.
COMMANDS = ("train", "adopt", "formats", "rom", "image", "diagnose", "loop", "loop-report", "measure", "import")


class _OneLineParser(argparse.ArgumentParser):
    def error(self, message: str):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: list[str] | None = None) -> int:
    """Run one command of a user; returns the exit status (0, or 2 for bad input)."""
    return run("gravcomp", "Gravity compensation of a robot in an FPGA.", "gravcomp.commands", COMMANDS, argv)


def run(program: str, description: str, package: str, commands: Sequence[str], argv: list[str] | None) -> int:
    """Run one of a program's commands, each a module of package; returns the exit status."""
    parser = _OneLineParser(prog=program, description=description)
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="command")
    modules = {}
    for command in commands:
        modules[command] = module = importlib.import_module(f"{package}.{_module_name(command)}")
        summary = module.__doc__.strip().splitlines()[0]
        module.add_arguments(subparsers.add_parser(command, help=summary, description=module.__doc__))
    arguments = parser.parse_args(argv)
    try:
        modules[arguments.command].run(arguments)
    except InputError as error:
        print(f"{program} {arguments.command}: {error}", file=sys.stderr)
        return 2
    except MemoryError:
        print(f"{program} {arguments.command}: not enough memory; ask for less", file=sys.stderr)
        return 2
    return 0


def _module_name(command: str) -> str:
    return "import_" if command == "import" else command.replace("-", "_")


if __name__ == "__main__":
    sys.exit(main())

"""The command line: ``gravcomp <command>``. One module of ``gravcomp.commands`` per command.

Bad input of any kind ends in one line on standard error and exit status 2.
"""

import argparse
import importlib
import pkgutil
import sys

from gravcomp import commands
from gravcomp.errors import InputError


class _OneLineParser(argparse.ArgumentParser):
    def error(self, message: str):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: list[str] | None = None) -> int:
    """Run one command; returns the exit status (0, or 2 for bad input)."""
    parser = _OneLineParser(prog="gravcomp", description="Gravity compensation of a parallel robot in an FPGA.")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="command")
    modules = {}
    for name in sorted(info.name for info in pkgutil.iter_modules(commands.__path__)):
        command = name.strip("_").replace("_", "-")
        modules[command] = module = importlib.import_module(f"{commands.__name__}.{name}")
        summary = module.__doc__.strip().splitlines()[0]
        module.add_arguments(subparsers.add_parser(command, help=summary, description=module.__doc__))
    arguments = parser.parse_args(argv)
    try:
        modules[arguments.command].run(arguments)
    except InputError as error:
        print(f"gravcomp {arguments.command}: {error}", file=sys.stderr)
        return 2
    except MemoryError:
        print(f"gravcomp {arguments.command}: not enough memory; ask for less", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

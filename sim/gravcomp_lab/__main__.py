"""``python -m gravcomp_lab <command>``: what make runs to measure and prove the project itself."""

import pkgutil
import sys

from gravcomp import cli
from gravcomp_lab import commands


def main(argv: list[str] | None = None) -> int:
    """Run one command of the lab; returns the exit status (0, or 2 for bad input)."""
    names = sorted(info.name.replace("_", "-") for info in pkgutil.iter_modules(commands.__path__))
    return cli.run("gravcomp-lab", "What the project measures and proves of itself.", commands.__name__, names, argv)


if __name__ == "__main__":
    sys.exit(main())

"""The one error that a user of gravcomp is meant to read."""

import importlib
import sys


class InputError(ValueError):
    """Bad input. The message is one line: what is wrong, where, what to do.

    The command line prints it and ends with exit status 2.
    """


def optional(module: str, package: str, purpose: str):
    """Import a module of a package that only an extra of pyproject.toml installs; InputError says how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        how = f"start `{sys.executable} -m pip install {package}`"
        raise InputError(f"{package} is not installed, and {purpose} needs it; {how}") from None

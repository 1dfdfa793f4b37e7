"""Libraries that only some importers need: extras, imported where they are used."""

import importlib
from types import ModuleType

from gravcomp.errors import InputError


def library(module: str, extra: str) -> ModuleType:
    """The module. Raises InputError that says what to install where it is missing."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InputError(f"{package} is not installed, and files of kind {extra} need it; "
                         f"pip install 'gravcomp[{extra}]'") from error  # fmt: skip

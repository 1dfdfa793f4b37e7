"""What comes with the package beside Python: the RTL, the register map, the C driver, the import scripts, a machine."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED, _CHECKOUT = _PACKAGE / "shipped_files", _PACKAGE.parents[1]
IS_CHECKOUT = not _INSTALLED.is_dir()


def shipped(name: str) -> Path:
    """A file or folder by its path in the repository: in a checkout that itself, in an installation its copy.

    pyproject.toml lists what a wheel holds.
    """
    return (_CHECKOUT if IS_CHECKOUT else _INSTALLED) / name

"""What comes with the package beside Python: the RTL, the register map, the C driver, the import scripts, a machine."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED, _CHECKOUT = _PACKAGE / "shipped_files", _PACKAGE.parents[1]
# What a project folder holds of it, too; pyproject.toml puts the same into a wheel, and the built-in machines.
SHIPPED = (
    *("rtl", "host", "constraints", "docs/guide", "gravcomp.core", "LICENSE"),
    *(f"scripts/{name}.tcl" for name in ("import_common", "vivado_import", "quartus_import", "radiant_import")),
    *(f"tb/hdl/{name}.vhd" for name in ("gc_hold_bench", "gc_vectors_bench")),
)
IS_CHECKOUT = not _INSTALLED.is_dir()


def shipped(name: str) -> Path:
    """A file or folder by its path in the repository: in a checkout that itself, in an installation its copy."""
    return (_CHECKOUT if IS_CHECKOUT else _INSTALLED) / name


def built_in() -> list[str]:
    """The names of the machines that come with the package: folders of weights/."""
    return sorted(path.name for path in shipped("weights").iterdir() if path.is_dir())

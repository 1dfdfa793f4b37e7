"""MATLAB files: vectors, arrays (n, k), arrays by joint, pose and repeat; up to version 7 by SciPy, 7.3 by h5py."""

from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional
from gravcomp.logs.importers.signals import Signal

DIMENSIONS = ("joint", "pose", "repeat")


def mat_signals(path: Path, dimensions: tuple[str, ...] = DIMENSIONS) -> dict[str, Signal]:
    """Variables of the file by name, fields of a structure as ``structure.field``.

    dimensions: which is which in arrays of three, and by their size in arrays of fewer. Rows are all repeats of the
    first pose, then those of the next. Raises InputError.
    """
    if sorted(dimensions) != sorted(DIMENSIONS):
        raise InputError(f"--dims {','.join(dimensions)}: give {','.join(DIMENSIONS)} in the order of the file")
    arrays = {name: np.asarray(value, float) for name, value in _variables(path)
              if np.issubdtype(np.asarray(value).dtype, np.number) and np.size(value) > 1}  # fmt: skip
    of_three = next((value.shape for value in arrays.values() if value.ndim == len(DIMENSIONS)), None)
    if of_three is None:
        return {name: Signal(_upright(value)) for name, value in arrays.items() if value.ndim <= 2}
    sizes = dict(zip(dimensions, of_three, strict=True))
    return {name: Signal(_rows(path, name, value, sizes)) for name, value in arrays.items()}


def _variables(path: Path):
    """(name, value) of everything in the file."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        yield from _of_version_7_3(path)
        return
    except (OSError, ValueError, TypeError, MatReadError) as error:
        raise InputError(f"{path}: no MATLAB file ({error}); give a .mat") from error
    yield from _flat({name: value for name, value in content.items() if not name.startswith("__")})


def _flat(table: dict, prefix: str = ""):
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _of_version_7_3(path: Path):
    h5py = optional("h5py", "h5py", "a MATLAB file of version 7.3")
    found = []
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.append((name.replace("/", "."), item[()].T))
                        if isinstance(item, h5py.Dataset) and not name.startswith("#") else None)  # fmt: skip
    return found


def _upright(value: np.ndarray) -> np.ndarray:
    """(n,) or (n, k): the longer side is that of the samples."""
    value = value.squeeze()
    return value.T if value.ndim == 2 and value.shape[0] < value.shape[1] else value


def _rows(path: Path, name: str, value: np.ndarray, sizes: dict[str, int]) -> np.ndarray:
    """(poses x repeats, joints), or (poses x repeats,) of an array without joints."""
    value = value if value.ndim == len(sizes) else value.squeeze()
    own = [*sizes] if value.ndim == len(sizes) else _dimensions_of(path, name, value, sizes)
    order = [dimension for dimension in ("pose", "repeat", "joint") if dimension in own]
    value = value.transpose([own.index(dimension) for dimension in order])
    whole = [sizes["pose"], sizes["repeat"]]
    here = [sizes[d] if d in own else 1 for d in ("pose", "repeat")]
    joints = value.shape[-1:] if "joint" in own else ()
    return np.broadcast_to(value.reshape(*here, *joints), (*whole, *joints)).reshape(-1, *joints)


def _dimensions_of(path: Path, name: str, value: np.ndarray, sizes: dict[str, int]) -> list[str]:
    """Which dimensions an array of fewer has, told by their sizes."""
    out = []
    for size in value.shape:
        fitting = [dimension for dimension, whole in sizes.items() if whole == size and dimension not in out]
        if not fitting:
            whole = ", ".join(f"{size} {dimension}s" for dimension, size in sizes.items())
            raise InputError(f"{path}: {name} is {value.shape}, and there are {whole}; say the order with --dims")
        out.append(fitting[0])
    return out

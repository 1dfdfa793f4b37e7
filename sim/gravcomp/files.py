"""Writing files so that nothing is ever half written."""

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from gravcomp.errors import InputError


def check_folder(folder: Path) -> None:
    """Raise InputError unless files can be written to folder, which may not be there yet; nothing is written."""
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        raise InputError(f"{there}: is a file; give a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(f"{there}: cannot be written; check its permissions, or give another folder")


def check_file(path: Path) -> None:
    """Raise InputError unless a file can be written at path; nothing is written."""
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is {'a folder' if path.is_dir() else 'a device or a pipe'}; give a file")
    check_folder(path.parent)


def write_atomically(path: Path | str, content: str | bytes) -> None:
    """Write content to a temporary file beside path, then rename it: the old file stays whole until the new one is.

    Raises InputError when the folder cannot be made or written.
    """
    write_all_atomically({Path(path): content})


def write_all_atomically(contents: Mapping[Path, str | bytes]) -> None:
    """Write several files that belong together: no old one is replaced before all new ones are on disk.

    Raises InputError when a folder cannot be made or written.
    """
    temporaries = {}
    try:
        for path, content in contents.items():
            temporaries[path] = _write_temporary(path, content)
        for path, temporary in temporaries.items():
            os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); check the folder") from error
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """A folder to fill, whose content is folder's when the block ends well; otherwise nothing of it stays.

    Raises InputError when folder is there and not empty, or cannot be written.
    """
    check_folder(folder)
    made = [path for path in (folder, *folder.absolute().parents) if not path.exists()]
    if not made and any(folder.iterdir()):
        raise InputError(f"{folder}: is not empty; give a folder that is not there yet")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".new-") as draft:
            yield Path(draft)
            for path in Path(draft).iterdir():
                path.rename(folder / path.name)
    except BaseException as error:
        if made:
            shutil.rmtree(made[-1], ignore_errors=True)
        if isinstance(error, OSError):
            raise InputError(f"{folder}: cannot be written ({error.strerror}); check the disk") from error
        raise


def _write_temporary(path: Path, content: str | bytes) -> Path:
    data = content.encode("utf-8") if isinstance(content, str) else content
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        raise IsADirectoryError(None, "it is a folder")
    if path.exists() and not path.is_file():
        raise OSError(None, "it is no file, but a device or a pipe")  # which the new file would replace
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with open(descriptor, "wb") as file:  # a full disk shows when the file is closed
            file.write(data)
        temporary.chmod(0o644)
    except BaseException:  # an interrupt, too, leaves nothing behind
        temporary.unlink()
        raise
    return temporary

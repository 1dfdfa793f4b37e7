"""Writing files so that nothing is ever half written."""

import os
import tempfile
from pathlib import Path

from gravcomp.errors import InputError


def write_atomically(path: Path | str, content: str | bytes) -> None:
    """Write content to a temporary file beside path, then rename it: the old file stays whole until the new one is.

    Raises InputError when the folder cannot be made or written.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            temporary = file.name
            file.write(data)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written ({error.strerror}); check the folder") from error

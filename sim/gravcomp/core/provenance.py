"""Where trained weights come from: provenance.json beside the CSV files."""

import json
import subprocess
from pathlib import Path

import numpy as np
import scipy

from gravcomp.files import write_atomically

PROVENANCE_JSON = "provenance.json"


def write_provenance(folder: Path | str, *, command: str, data: dict, metrics: dict) -> None:
    """Write provenance.json: command, state of the source, versions, data and metrics. Raises InputError."""
    content = {
        "command": command,
        "commit": source_version(),
        "versions": {"numpy": np.__version__, "scipy": scipy.__version__},
        "data": data,
        "metrics": metrics,
    }
    write_atomically(Path(folder) / PROVENANCE_JSON, json.dumps(content, indent=2) + "\n")


def source_version() -> str:
    """Commit of the source, with -dirty when files differ from it; "unknown" outside a git clone."""
    call = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(call, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"

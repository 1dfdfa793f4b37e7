"""Where trained weights come from: provenance.json beside the CSV files."""

import json
import subprocess
from pathlib import Path

import numpy as np
import scipy

from gravcomp import __version__
from gravcomp.files import write_atomically
from gravcomp.robot.machine import Machine, trained_on_hash
from gravcomp.shipped import IS_CHECKOUT

PROVENANCE_JSON = "provenance.json"


def write_provenance(folder: Path | str, **content) -> None:
    """Write provenance.json, as ``provenance_text`` has it. Raises InputError."""
    write_atomically(Path(folder) / PROVENANCE_JSON, provenance_text(**content))


def provenance_text(*, command: str, data: dict, metrics: dict, machine: Machine) -> str:
    """The text of provenance.json: command, state of the source, versions, data, metrics, and the facts of the machine
    that the network was trained on, with their hash.
    """
    facts = machine.trained_on()
    content = {
        "command": command,
        "commit": source_version(),
        "versions": {"numpy": np.__version__, "scipy": scipy.__version__},
        "data": data,
        "metrics": metrics,
        "machine": {"sha256": trained_on_hash(facts), "trained_on": facts},
    }
    return json.dumps(content, indent=2) + "\n"


def source_version() -> str:
    """Of a checkout the commit, -dirty when files differ from it, "unknown" without git; installed, the version."""
    if not IS_CHECKOUT:
        return __version__  # a git that the installation lies in is another project's
    call = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(call, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"

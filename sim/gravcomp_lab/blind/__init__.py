"""Blind tally: sets drawn by seed, diagnosed, then opened and counted."""

import subprocess


def seed_of_commit() -> int:
    """The first seven digits of the commit's hash: no one who tunes the code can choose it."""
    found = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True)
    return int(found.stdout[:7], 16)

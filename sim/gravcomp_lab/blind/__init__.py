"""Blind tally: sets drawn by seed, diagnosed, then opened and counted."""

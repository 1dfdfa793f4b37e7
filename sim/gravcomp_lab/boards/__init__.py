"""Bitstreams for the boards of boards/."""

"""Measured data: in memory, from CSV, from public data sets."""

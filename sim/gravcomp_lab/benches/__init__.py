"""Benches: coroutines that drive the simulated RTL, and functions that run them and return what they measured."""

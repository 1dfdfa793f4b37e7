"""Robots: what is to be held, from positions to efforts."""

"""Robots of a URDF or MJCF file: [model] kind = "mujoco"."""

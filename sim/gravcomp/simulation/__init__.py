"""The only caller of the simulators."""

"""The virtual prototype: a machine in MuJoCo with imperfections, to measure on."""

MODES = ("static", "motion", "both")
DEFAULT_NOISE_N = 0.1

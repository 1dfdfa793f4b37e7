"""Every threshold by which a measurement in memory is read, each with where it comes from.

Those of the diagnosis are in ``gravcomp.diagnosis.thresholds``; ``python -m gravcomp_lab sensitivity`` takes both.
"""

LARGEST = 1e15  # of any measured value: sums of squares stay far from overflow

# Direction
DEAD_BAND_GRID = 1.5  # steps of the grid of v: one step either way is the rounding of a difference of two positions
DEAD_BAND_NOISE = 3.0  # deviations of the noise of v: a Gaussian is farther off 1 time in 370
DEAD_BAND_CAP = 0.02  # of the usual speed: a noise above it is no noise of rest; not measured
DEAD_BAND_ROWS = 8  # of motion: fewer fourth differences tell no noise
MAD = 0.6745  # median absolute deviation of a Gaussian, in standard deviations
FOURTH_DIFFERENCE = 70.0  # 1 + 16 + 36 + 16 + 1: variance of a fourth difference, in that of a row
USUAL_TOP = 0.95  # quantile of a size that a log reaches as usual, outliers apart
STANDS_STILL = 0.3  # of the rows without a direction: an axis that turns has fewer at its reversals; not measured
FEWEST_ON_GRID = 4  # values: through three a grid runs by chance 1 time in 100, as below
GRID_SHARE = 0.7  # values per row: noise gives each row its own
OFF_GRID = 0.05  # of a step: a value without a grid is nearer 1 time in 10, one of them and zero aside

# Motion
MOTION_ROWS = 8  # fewer rows are no motion; not measured
MOTION_TOLERANCE = 0.5  # of the step that v announces: rows that keep to it are motion, others are separate holds
MOTION_ROUNDING = 1e-3  # of the range: a row at a reversal, whose v announces nothing; not measured
MOTION_AROUND, MOTION_MOST = 9, 0.7  # rows, and the part of them that keeps to v; not measured
MOTION_LEAST = 0.05  # of the rows: so many holds keep to their v by chance; not measured
ORDERED = 0.1  # of the variance between rows: holds in random order have 1, a sine of n rows 1 - cos(2 pi/n): 14 rows

# Places
HELD = 0.7  # places per row: fewer were visited again; not measured
AS_TIME = 0.9  # of the variance of the time that places and directions of one axis tell; not measured

# Derivatives
CENTRAL_STEP = 1e-5  # of the range: about the cube root of the rounding, where a central difference errs least
SMOOTH_PART, SMOOTH_FEWEST, SMOOTH_MOST = (
    200,
    2,
    10,
)  # rows either side: 1 in 200, between five and 21 in all; not measured

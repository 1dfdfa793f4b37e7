"""Every threshold of the diagnosis, each with where it comes from.

"tuned": chosen on sets of the blind generators with seeds below 200, never on the seeds that are tallied. What half and
twice a number does to such sets is printed by ``python -m gravcomp_lab sensitivity NAME``.
"""

# Robust statistics
HUBER = 2.5  # textbook value: 95 % efficient on Gaussian noise lies at 1.345, beyond 2.5 a Gaussian has 1 %
MAD_TO_SIGMA = 1.4826  # median absolute deviation of a Gaussian, 1/0.6745
HUBER_TURNS = 2  # fits with weights of the one before

# Price of a term in the criterion, as 2 log of the number of terms that compete
PHYSICAL_PRICE = 8.0  # some 50 terms of effects
EMPIRICAL_PRICE = 20.0  # some hundred corrections per axis, and physics first where both fit; tuned
CORNER_PRICE = 8.0  # 2 log of the sixty corners scanned
SCAN_PRICE = 14.0  # 2 log of the thousand frequencies scanned
COMPLEXITY = {  # on top of an effect's price, by how usual it is: odds of exp(c/2) before any data; by judgement
    "everywhere": 0.0,  # friction of Coulomb, a load, a motor constant, a sensor
    "usual": 0.5,  # an offset, a spring, a tilt: odds of 1.3, they only decide between equals
    "common": 1.0,  # drag, inertia, friction by load, of Coulomb by direction
    "uncommon": 2.0,  # play, elasticity, hoses, friction of joints without a drive, warmth
    "rare": 3.0,  # friction by place or by reaction, or other in each joint
    "rarer": 4.0,  # what has a shape of its own, or an hour: odds of 7
    "general": 6.0,  # forms of two coefficients an axis and more
    "most general": 8.0,  # of ten
}

# Sets of terms
TIE = 9.0  # scores this close cannot be told apart: odds of exp(9/2), about 90
NEGATIVE_Z = 3.0  # a coefficient that physics makes positive is refused beyond three standard errors below zero
MAX_TERMS = 14  # as many as 3 axes have ever needed; bounds the time, which 30 double on a real arm of six
CANCELLATION = 3.0  # single terms may have this many times the energy of their sum; tuned
TRIFLE = 0.005  # of the energy explained: an effect below may imitate an error of the others; tuned
TRIFLE_LEFT = 0.1  # of the energy left: an effect that takes more is none, however small beside the rest; tuned
FORM_LEFT = 0.25  # likewise: a general form that takes more than its special case; two real machines need 0.14 to 0.60
BESIDE_CORRECTION = 0.1  # of the energy explained: what a name must account for beside corrections; tuned
NAMED_BESIDE = 3.0  # times what no name accounts for: what a name that accounts for less may be a part of; tuned
AS_A_TABLE = 4  # coefficients on one axis: a name with so many fits much, as a table does
MISSED = 0.005  # of the energy that can be explained: effects that miss less are the whole story; tuned
VAGUE = 4  # names: beside corrections one with more rivals says nothing; tuned
SAME_COLUMN = 1.0 - 1e-9  # correlation of two regressors that are one
SAME_SCORE = 1e-6  # what lies within the span of the other terms adds nothing
PROMISING = 20  # candidates of a move that are scored exactly; more changed no outcome on tuned seeds
REFUSED = 80  # candidates until a move is given up where physics refuses all before: a real arm's best twenty were
BEAM_WIDTH, BEAM_DEPTH = 4, 4  # sets that go on, and terms they are led by; bounds the time
FOLDS = 4  # of a cross-validation within the training
SURFACE_DEGREE = 3  # of a smooth function of all positions

# Samples and columns that are wrong
GROSS = 8.0  # robust standard deviations outside the neighbours: a Gaussian never, Student's t of 4 degrees 1 in 500
GROSS_SHARE = 0.05  # of the samples: more are a part of the machine
LEAK = 0.9  # correlation of the deviation from a place with the effort; 0.999 on a real joint without integral
SIGN_GAIN = (-1.5, -0.67)  # effort over model: nearer -1 than any other reading
SLOW_SHARE = 0.4  # of the samples of an axis at a reversal somewhere in the machine: with more too few are left
TWO_VALUED = 4.5  # inner deviations between two means: 2.7 for a Gaussian, 3.5 for an even spread
TWO_VALUED_SIDE = 0.15  # of the samples at either value at least: a few on one side are outliers; not measured
GROSS_SIDE = 4  # samples looked at on either side along time
GROSS_NEAR = 12  # samples looked at in pose, of which the two most extreme on either side do not count
UNIT_FIT = 0.9  # correlation of v with dq/dt from which their ratio means something
UNIT_RIGHT = 0.1  # ratio of v to dq/dt this near 1 is right
UNIT_NEAR = 0.05  # of a known factor

CLEARLY_LESS = 0.85  # of what the plain reading of a log leaves: another reading of it is the right one; tuned
AS_MUCH = 1.05  # of it: as good with fewer terms; tuned
SURELY_LESS = 30.0  # twice a difference of log likelihoods: the same effects read otherwise, odds of e^15

# Clock and columns of a motion
CLOCK_ROWS = 60  # a deviation of the step is then known to 9 %, 1/sqrt(2n)
CLOCK_JITTER = 0.05  # of the step: less hurts no derivative
CLOCK_MISSING = 3.0  # steps: a longer one has rows missing, and the clock is no straight line
CLOCK_EVEN = 0.5  # of what the positions are off beside their neighbours at the stamps
HELD_FRESH = 0.7  # values per stretch of equal ones: fewer are steps of a converter, not of a clock
HELD_REGULAR = 0.9  # of the stretches are as long as the usual one, or a row more or less
HELD_KEEPS_UP = 0.3  # of v dt: what the steps of held positions may be off; repeats of a hold announce no motion
STUCK_ROWS, STUCK_CHANCE = 4, 1e-4  # rows at one value; stretches as long that chance makes in a whole log
STUCK_LEAP, STUCK_USUAL = 3.0, 0.95  # usual large steps: a turning point of a coarse converter has no leap beside it

# Samples that are held out, in blocks
TEST_SHARE = 0.25  # as usual: the error of 25 % of a log is known to 1/sqrt(n/2)
MOST_HELD_OUT = 0.5  # of the samples, where a single block is larger than that share
FEWEST_PLACES = 10  # distinct poses that a fit must have seen
BLOCKS = 8, 40  # fewest: two of them are TEST_SHARE; most: more would be held out in pieces too small; not measured
BLOCK_ROWS, CLUSTER_ROWS = 25, 12  # of a motion, of scattered holds: 200 and 96 have the fewest blocks; not measured
MOSTLY_HOLDS = 0.3  # of the rows in motion: fewer are stretches between holds
REPEATED = 0.7  # fewer poses than this part of the rows: they were held again

# The noise that no model made, and what the remainder may be
NOISE_SAMPLES = 24  # differences: their deviation is known to 15 %
NOISE_AT_LEAST = 0.85  # of its estimate: that error
NOISE_STRIDE, NOISE_STRIDES = 0.03, 6  # of the range, and samples: a pose that moved less is the same; tuned
NOISE_WINSOR = 5.0  # Student's t of 4 degrees has 0.7 % beyond, which count; jumps at reversals are larger
NEAR_NEIGHBOUR = 0.1  # of the range: through farther ones no line can be drawn to distance zero; tuned
NOISE_SPEED = 0.3  # weight of a speed beside a position; of 80 logs 0.15 tells the noise to 6.3 %, 0.6 to 5.3 %
NOISE_NEIGHBOURS, NOISE_CANDIDATES = 8, 100  # on the line; looked at for those, as a motion has many beside it in time
NOISE_APART = 0.02  # of the log: samples nearer in time are no repeats, their noise may be the same
NOISE_ROWS = 2500  # decide a standard deviation to 2 %
SAME_POSE = 1e-3  # of the range: a hold that was sent to one place again
NOISE_LEAST = 0.3  # of the variance between nearest neighbours: what the line through them may leave at distance zero
NOISE_GROUPS, NOISE_RISES = 10, 3.0  # stretches, each left out once; standard errors by which a line surely rises
REMAINDER = 1.2  # times that noise: more is never explained

# Numbers
SINGULAR = 1e-9  # of the largest eigenvalue: squared rounding of regressors
TINY = 1e-300  # above zero, so that nothing is divided by it: below any square of a measured value
IMPOSSIBLE = 1e12  # score of a set that physics refuses
DIFFERENCE_STEP = 1.5e-8  # of a parameter, in difference quotients: root of the rounding
PULL = 1e-6  # toward the start, beside what a parameter moves: far above rounding, far below noise
RIDGE_LEAST = 1e-9  # of a column: 1e5 times the rounding of a sum over 1e4 samples, below 1 over any real log
INDEPENDENT = 1e-6  # of the largest regressor: less is left of one beside those of bodies nearer to the base
AT_REST = 1e-9  # of the speed that the axes could give a joint: less is rest

# The search
ROUNDS = 3  # outliers, noise and correlation settle after two; tuned
REFINE_SAMPLES = 1200  # decide a shape to a few per cent
SEARCH_SAMPLES = 5000  # more changes no decision, and costs time
MINOR_SHARE = 0.03  # of what was explained: a correction this small does not spoil an explanation; tuned

# Scans of one variable. "60 pitches": seed 5, two harmonics of 0.5 to 2 times the noise each, 1500 samples;
# as it is all 60 are found, with no other harmonic, and so are 60 of a whole turn.
LINE_GRID = 16384  # bins: 1000 cycles lose 1.2 % of their power, 1 - sinc^2(1000/16384); with half as many 4.8 %
LINE_MIN_CYCLES = 3.0  # the trend leaves at least 59 % of their power, of 2.5 cycles 18 %, of 2 cycles 2 %
LINE_TREND = 6  # degree: takes all but 2 % of what has up to a cycle and a half
LINE_STEPS = 3  # quarter cycles that a peak may lie beside its line: of 3 cycles one, of 2.5 two
LINE_MAX_CYCLES = 1000  # those that SCAN_PRICE is for
LINE_ODDS = 7.0  # a false line in exp(7) scans, about 1100
MAX_LINES = 14  # bounds the time; the 60 pitches needed three
MAX_ORDER = 30  # of a pitch that is no whole turn; 15 and 60 change none of the 60 pitches
LINE_RESOLUTION = 0.3  # cycles; a scan steps by 0.25; of the 60 pitches 0.15 loses one, 0.6 none
TURN_RESOLUTION = 0.6  # likewise, where the pitch is known and a line can only belong to it; 0.3 and 1.2 change none
ORDERS_APART = 0.9  # cycles over the range, of neighbouring harmonics of a pitch; 0.45 loses no pitch of a turn
DIVISORS = 6  # harmonics that the strongest line may be: of the 60 pitches 3 lose 12, 12 none
LARGER_PITCH = 0.98  # of the power explained, for each divisor more: 0.9 loses 6 of the 60 pitches, 1 none
WAVE_SEEN = 2.2  # distances of places per wave: at two a wave and its image cannot be told apart
STEP_EDGE = 0.05  # of the log: a step nearer to its ends is a transient
CORNERS = 60  # quantiles, then two finer grids: of 60 hinges at the noise 3e-6 of the gain is lost, with 30 4e-4
CORNERS_INSIDE = 0.03, 0.97  # quantiles: beyond them too few samples are on one side
CORNER_PAIRS = 10  # quantiles that a pair of corners starts from: of 60 pairs 5 lose up to 5e-5 of the gain, 10 nothing
CORNER_TURNS = 3  # of each corner of a pair beside the other one; of those 60 one turn loses up to 2e-3, 3 nothing
CORNER_ROWS = 20  # what a corner takes off pure noise does not depend on it: 5.7 s^2 of 20, 6.1 of 400, 95th percentile
MOST_BENT = 0.1  # of the range of an axis

# What is logged late. Measured on 73 motions of the blind generators, seeds below 40, without a lag and with one of
# three rows: as it is 3 false lags and 57 true ones are found. "16 (2, 51)": with 16 these two.
LAG_ROWS = 200  # 100 (3, 57), 400 (3, 57)
LAG_REVERSAL = 12  # rows on either side of a reversal that friction and lag share; 6 (3, 57), 24 (3, 53)
LAG_SURE = 8.0  # standard errors of the lag; without one 1 axis in 20 has above 6.9; 4 (3, 60), 16 (2, 51)
LAG_AGREE = 4.0, 0.25  # standard errors, part of the lag: axes farther apart have none; half (2, 55), twice (3, 57)
LAG_MATTERS = 0.3  # of the remainder: what the lag must take; 0.15 (3, 57), 0.6 (1, 56)
LAG_STEPS = 1.5  # of the clock: a difference to the row before is half a step late, and hurts nobody
LAG_OF_V = 0.03  # of the usual speed: what the lag of v must make of it
LAG_TURNS = 6  # Gauss-Newton, which a lag of a quarter of a period needs; 3 (3, 57), 12 (3, 57)
LAG_SETTLED = 4.0  # lags after a reversal: a first-order filter has settled to e^-4, 2 %
LAG_REVERSALS = 6  # fewer tell a lag from nothing; 3 (3, 58), 12 (3, 55)
LAG_LEVELS, LAG_GRID = 4, 24  # of a search, each within two lags of the last: a part in 24 (24/4)^3 of its range

# What is left
LEFT_SAMPLES, LEFT_SAMPLES_USED = 400, 2500  # fewer give random trees nothing to hold; more cost seconds
LEFT_R2 = 0.05  # of the variance, predicted in cross-validation; tuned on noise
LEFT_SHARE = 0.003  # of the variance before: less is not worth a line

# What a report says
JOINT_SHARE = 0.005  # of the variance: less is not worth a line
WORST_SHOWN, WORST_APART = 5, 0.05  # samples; of the range: nearer poses are one place

# The next measurement
ENOUGH = 60.0  # score differences scatter by 2 sqrt(E): three deviations below still leave more than TIE, 60 - 46 > 9
PLAN_NEAR = 3.0 * TIE  # scores of rivals, fitted anew
PLAN_WORTH = 2.0 * TIE  # E that the best measurement must reach for two rivals to be worth one
PLAN_ROUNDING = 1e-9  # in squares of the noise
PLAN_POOL = 500  # holds to choose from
MOST_HOLDS, FEWEST_HOLDS = 200, 30  # fewer hang on the names that the rivals happen to have
PLAN_SPEEDS = 1.0, 0.3, 0.1, 0.03  # of the fastest in the log
PLAN_STROKES = 1.0, 0.3, 0.1, 0.02  # of the log's path, to and fro
PLAN_STARTS = 0.25, 0.5, 0.75  # along it
PLAN_POSES = 8  # that a motion through the workspace passes
PLAN_ROWS = 60, 120, 240, 480, 960, 1920  # lengths tried, each twice the last: at most twice as long as need be

"""Every threshold of the diagnosis, each with where it comes from.

"tuned": chosen on sets of the blind generators with seeds below 200, never on the seeds that are tallied.
"""

# Robust statistics
HUBER = 2.5  # textbook value: 95 % efficient on Gaussian noise lies at 1.345, beyond 2.5 a Gaussian has 1 %
MAD_TO_SIGMA = 1.4826  # median absolute deviation of a Gaussian, 1/0.6745

# Price of a term in the criterion, as 2 log of the number of terms that compete
PHYSICAL_PRICE = 8.0  # some 50 terms of effects
EMPIRICAL_PRICE = 20.0  # some hundred corrections per axis, and physics first where both fit; tuned
CORNER_PRICE = 8.0  # 2 log of the sixty corners scanned
SCAN_PRICE = 14.0  # 2 log of the thousand frequencies scanned

# Sets of terms
TIE = 9.0  # scores this close cannot be told apart: odds of exp(9/2), about 90
NEGATIVE_Z = 3.0  # a coefficient that physics makes positive is refused beyond three standard errors below zero
MAX_TERMS = 14  # as many as 3 axes have ever needed; bounds the time
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
BEAM_WIDTH, BEAM_DEPTH = 4, 4

# Samples and columns that are wrong
GROSS = 8.0  # robust standard deviations outside the neighbours: a Gaussian never, Student's t of 4 degrees 1 in 500
GROSS_SHARE = 0.05  # of the samples: more are a part of the machine
LEAK = 0.9  # correlation of the deviation from a place with the effort; 0.999 on a real joint without integral
SIGN_GAIN = (-1.5, -0.67)  # effort over model: nearer -1 than any other reading
SLOW_SHARE = 0.4  # of the samples of an axis at a reversal somewhere in the machine: with more too few are left
TWO_VALUED = 4.5  # inner deviations between two means: 2.7 for a Gaussian, 3.5 for an even spread

CLEARLY_LESS = 0.85  # of what the plain reading of a log leaves: another reading of it is the right one; tuned
AS_MUCH = 1.05  # of it: as good with fewer terms; tuned
SURELY_LESS = 30.0  # twice a difference of log likelihoods: the same effects read otherwise, odds of e^15

# The noise that no model made, and what the remainder may be
NOISE_SAMPLES = 24  # differences: their deviation is known to 15 %
NOISE_STRIDE, NOISE_STRIDES = 0.03, 6  # of the range, and samples: a pose that moved less is the same; tuned
NOISE_WINSOR = 5.0  # Student's t of 4 degrees has 0.7 % beyond, which count; jumps at reversals are larger
NEAR_NEIGHBOUR = 0.1  # of the range: through farther ones no line can be drawn to distance zero; tuned
REMAINDER = 1.2  # times that noise: more is never explained

# Numbers
SINGULAR = 1e-9  # of the largest eigenvalue: squared rounding of regressors
TINY = 1e-300
IMPOSSIBLE = 1e12  # score of a set that physics refuses

# The search
ROUNDS = 3  # outliers, noise and correlation settle after two; tuned
REFINE_SAMPLES = 1200  # decide a shape to a few per cent
SEARCH_SAMPLES = 5000  # more changes no decision, and costs time
MINOR_SHARE = 0.03  # of what was explained: a correction this small does not spoil an explanation; tuned

# What is left
LEFT_SAMPLES, LEFT_SAMPLES_USED = 400, 2500  # fewer give random trees nothing to hold; more cost seconds
LEFT_R2 = 0.05  # of the variance, predicted in cross-validation; tuned on noise
LEFT_SHARE = 0.003  # of the variance before: less is not worth a line

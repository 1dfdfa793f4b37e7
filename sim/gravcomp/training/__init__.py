"""Training: Levenberg-Marquardt, basin hopping, normalisation."""

BACKENDS = ("loky", "threading", "dask")  # of joblib

POLISH_STEPS = 1500  # of the best start on all poses, at most

"""Training: Levenberg-Marquardt, basin hopping, normalisation."""

BACKENDS = ("loky", "threading", "dask")  # of joblib

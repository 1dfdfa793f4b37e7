"""Training: Levenberg-Marquardt, basin hopping, normalisation."""

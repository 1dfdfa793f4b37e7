"""From measured data to the effects that a model lacks: candidates, search, fit, verdict, report."""

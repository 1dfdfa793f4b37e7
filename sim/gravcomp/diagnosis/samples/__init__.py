"""What of a log can be trusted: gross errors, sensors, the split into fitted and held out, noise."""

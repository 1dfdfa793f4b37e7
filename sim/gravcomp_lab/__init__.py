"""The project's own proof: what the repository measures of itself, run by make; no user installs it."""

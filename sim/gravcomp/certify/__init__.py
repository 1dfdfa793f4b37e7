"""A bound on the error of the core at every pose: Taylor models of statics and core, branch and bound over boxes."""

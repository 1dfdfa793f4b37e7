"""The search for the set of candidates that explains a residual: algebra, criterion, moves, rules."""

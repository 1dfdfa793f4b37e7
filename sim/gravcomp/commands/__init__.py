"""One module per command: its docstring is the help, ``add_arguments(parser)`` and ``run(arguments)`` do the rest.

A module imports at its top only what its arguments take; what costs time to import, numpy and all that is built on it,
is imported by ``run``, so that help and refused arguments come at once.
"""

"""The one error that a user of gravcomp is meant to read."""


class InputError(ValueError):
    """Bad input. The message is one line: what is wrong, where, what to do.

    The command line prints it and ends with exit status 2.
    """

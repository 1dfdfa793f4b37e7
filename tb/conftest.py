"""Tests hear an interrupt, and so do the processes that they start, though a shell that puts them into the background
lets them ignore it.
"""

import signal

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

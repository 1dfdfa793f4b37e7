"""``python -m gravcomp``: the command line."""

import sys

from gravcomp.cli import main

sys.exit(main())

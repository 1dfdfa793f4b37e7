"""Prove the largest error of the core over all poses of the workspace: |force of gc_core - statics| <= X.

Branch and bound over boxes of poses, with sound arithmetic and every dropped bit of the hardware; how, and what is not
in it: docs/guide/certify.md. With --bound it proves that bound, or refuses it with a pose and a box that break it.
"""

from pathlib import Path

from gravcomp.errors import InputError


def add_arguments(parser):
    parser.add_argument("weights", type=Path, help="machine folder")
    parser.add_argument("--bound", type=float, metavar="X", help="claim to prove, N or Nm, for every axis")
    parser.add_argument("--gap", type=float, default=1.0, metavar="PERCENT",
                        help="of X above what the worst pose alone allows (default %(default)s)")  # fmt: skip
    parser.add_argument("--minutes", type=float, default=10.0, help="after which it stops (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the search for the largest error (default %(default)s)")


def run(arguments):
    from gravcomp.certify.certificate import Certifier, certify
    from gravcomp.certify.report import lines
    from gravcomp.core.folder import load_folder
    from gravcomp.core.quantised import quantised

    for name in ("bound", "gap", "minutes"):
        value = getattr(arguments, name)
        if value is not None and not 0 < value < float("inf"):
            raise InputError(f"--{name} {value:g}: give a number above 0")
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed}: give a number from 0 on")
    content = load_folder(arguments.weights)
    certifier = Certifier(content.machine, quantised(content.machine, content.network, arguments.weights))
    certificate = certify(certifier, arguments.gap / 100.0, arguments.bound, 60.0 * arguments.minutes, arguments.seed)
    print("\n".join(lines(certifier, certificate, arguments.seed)))
    if arguments.bound is not None and not certificate.is_complete:
        raise InputError(f"--bound {arguments.bound:g} is not proven, nor broken; give more --minutes, or claim more")

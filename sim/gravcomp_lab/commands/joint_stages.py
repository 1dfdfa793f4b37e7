"""What stages for play and for friction of passive joints would gain, and cost: joints.md."""

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("--holds", type=int, default=400, help="of the virtual prototype (default %(default)s)")
    parser.add_argument("--network-rms", type=float, default=0.060, metavar="N",
                        help="force error of the network over the workspace, N RMS, as make sim prints it")  # fmt: skip
    parser.add_argument("--docs", type=Path, help="folder of joints.md")


def run(arguments):
    from gravcomp_lab.joint_stages import tables
    from gravcomp_lab.pages import renew
    from gravcomp_lab.shipped import shipped_machine

    text = tables(shipped_machine(), arguments.network_rms, arguments.holds)
    print(text)
    if arguments.docs:
        renew(arguments.docs / "joints.md", "stages", text)

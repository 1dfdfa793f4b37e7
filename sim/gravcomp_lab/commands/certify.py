"""The largest error of every shipped machine's core over all its poses, proven: certify.md."""

from pathlib import Path

SEED, GAP = 1, 0.01


def add_arguments(parser):
    parser.add_argument("--machines", nargs="+", metavar="NAME", help="of weights/ (default: all with a network)")
    parser.add_argument("--minutes", type=float, default=10.0, help="for each (default %(default)s)")
    parser.add_argument("--docs", type=Path, help="folder of certify.md")


def run(arguments):
    from gravcomp.certify.certificate import Certifier, certify
    from gravcomp.certify.report import lines
    from gravcomp.core.folder import load_folder
    from gravcomp.core.formats import quantise
    from gravcomp.errors import InputError
    from gravcomp.network.weights import HIDDEN_CSV
    from gravcomp.shipped import built_in, shipped
    from gravcomp_lab.pages import renew

    folders = {name: shipped(f"weights/{name}") for name in arguments.machines or built_in()}
    parts = []
    for name, folder in folders.items():
        if not (folder / HIDDEN_CSV).exists():
            continue
        content = load_folder(folder)
        try:
            certifier = Certifier(content.machine, quantise(content.network, content.machine.drive, folder))
        except InputError as refusal:
            parts.append(f"{name}: {str(refusal).partition(': ')[2]}")
            continue
        parts.append("\n".join(lines(certifier, certify(certifier, GAP, None, 60.0 * arguments.minutes, SEED), SEED)))
    text = "\n\n".join(parts)
    print(text)
    if arguments.docs:
        renew(arguments.docs / "certify.md", "machines", text)

"""A bitstream for a board: area, clocks against those that run, and what was packed against what was placed."""

from pathlib import Path

from gravcomp.errors import InputError


def add_arguments(parser):
    parser.add_argument("board", help="board and part, such as ulx3s-85f; `list` names all")
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    parser.add_argument("--selftest", action="store_true", help="axes inside the fabric in place of the pins")
    parser.add_argument("--seed", type=int, default=1, help="of the placement")
    parser.add_argument("--boards", type=Path, default=Path("boards"), help="folder of */board.toml")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="the result goes to its folder boards/")


def run(arguments):
    from gravcomp_lab.boards.bitstream import build
    from gravcomp_lab.boards.board import boards

    known = boards(arguments.boards)
    if arguments.board == "list":
        print("\n".join(known))
        return
    if arguments.board not in known:
        raise InputError(f"no board {arguments.board}; take one of {', '.join(known)}")
    board = known[arguments.board]
    out = arguments.build / "boards" / (board.name + "-selftest" * arguments.selftest)
    made = build(board, arguments.weights, arguments.rtl, out, selftest=arguments.selftest, seed=arguments.seed)
    print("| cells | used | of |\n|---|---|---|")
    for name, (used, available) in made.used.items():
        print(f"| {name} | {used} | {available} |")
    print("\n| clock | runs at | could run at |\n|---|---|---|")
    for clock in made.clocks:
        print(f"| {clock.name} | {clock.asked_mhz:.1f} MHz | {clock.reached_mhz:.1f} MHz |")
    print(f"\nseed {arguments.seed}; {made.file}: load it with `openFPGALoader --board {board.loader} {made.file}`")

"""Print the errors of a loop on held-out samples: analytic model, network and RTL, before and after.

Those of the RTL come from its simulation, which `make loop` runs in a clone.
"""

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("--loop", type=Path, default=Path("build/loop"), help="folder (default %(default)s)")


def run(arguments):
    from gravcomp.loop.loop import RUNS, error_table, noise_floor_n

    table, noise_n = error_table(arguments.loop), noise_floor_n(arguments.loop)
    print("| held-out samples | before: RMS, N | max, N | ave, % | after: RMS, N | max, N | ave, % |")
    print("|---|---|---|---|---|---|---|")
    for name, runs in table.items():
        cells = [f"{runs[run]['rms_n']:.3f} | {runs[run]['max_n']:.2f} | {runs[run]['ave_pct']:.2f}" for run in RUNS]
        print(f"| {name} | {' | '.join(cells)} |")
    print(f"\nNoise of the measurement: {noise_n:.3f} N RMS.")

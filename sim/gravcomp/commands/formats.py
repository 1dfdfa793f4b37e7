"""Print what the fixed-point core can ever compute, and how far it is from the float network."""

from pathlib import Path

N_POSES, SEED = 20000, 41


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")


def run(arguments):
    import numpy as np

    from gravcomp.core.folder import load_folder
    from gravcomp.core.quantised import quantised
    from gravcomp.twin.bounds import fixed_point_error_mn, intervals
    from gravcomp.twin.precision import certified, precision

    content = load_folder(arguments.weights)
    network, machine = content.network, content.machine
    fixed = quantised(machine, network, arguments.weights)
    print("Codes over all 2^32 counts per axis, by interval arithmetic on the weights:\n")
    print("| signal | lowest | highest | bits needed | bits |\n|---|---|---|---|---|")
    for name, interval in intervals(fixed).items():
        print(f"| {name} | {interval.low} | {interval.high} | {interval.needed_bits} | {interval.bits} |")
    error = fixed_point_error_mn(network, fixed, machine, N_POSES, SEED)
    rms, largest = np.sqrt((error**2).mean()), np.abs(error).max()
    print(f"\nFixed point against float over the workspace ({N_POSES} poses, seed {SEED}): ", end="")
    print(f"RMS {rms:.2f} mN, maximum {largest:.2f} mN.")
    cost = precision(network, fixed, machine.drive.unit_per_count)
    print(f"\nOver the whole trained range {cost}; `make rom` refuses more than {cost.limit_mn:.1f} mN RMS:\n")
    print("| stage | alone, mN RMS | its format is set by |\n|---|---|---|")
    for stage in cost.stages:
        print(f"| {stage.name} | {stage.rms_mn:.2f} | {stage.file} row {stage.row}, {stage.column} = {stage.value:g} |")
    certified(cost, arguments.weights)

"""Print what the fixed-point core can ever compute, and how far it is from the float network."""

from pathlib import Path

N_POSES, SEED = 20000, 41
SERIAL_BITS = range(12, 19)


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    help_ = "print what the serial form costs with weights of fewer bits instead, and end"
    parser.add_argument("--bits", action="store_true", help=help_)


def run(arguments):
    import numpy as np

    from gravcomp.core.folder import load_folder
    from gravcomp.core.quantised import quantised
    from gravcomp.twin.bounds import fixed_point_error_mn, intervals
    from gravcomp.twin.precision import certified, precision

    content = load_folder(arguments.weights)
    network, machine = content.network, content.machine
    if arguments.bits:
        return _print_trade(machine, network, arguments.weights)
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


def _print_trade(machine, network, folder: Path) -> None:
    """Bits of a weight in the serial form against its error."""
    from tqdm import tqdm

    from gravcomp.core import lean
    from gravcomp.errors import InputError

    q_m = machine.robot.workspace(lean.N_POSES, lean.SEED)
    rows = []
    for bits in tqdm(SERIAL_BITS, unit="width", leave=False):
        try:
            fixed = lean.lean_network(network, machine.drive, q_m, folder, serial_bits=bits)
        except InputError as error:
            if bits == max(SERIAL_BITS):
                raise
            rows.append(f"| {bits} | refused: {error} | | | |")
            continue
        rows.append(_trade_row(machine, network, fixed))
    print(
        f"Serial form against float over the workspace ({N_POSES} poses, seed {SEED}); `form = 'serial'` takes "
        f"{lean.SERIAL_BITS} bits:\n"
    )
    print("| bits of a weight | mN RMS | largest, mN | bits of the sum | bits of all weights |\n|---|---|---|---|---|")
    print("\n".join(rows))


def _trade_row(machine, network, fixed) -> str:
    import numpy as np

    from gravcomp.twin.bounds import fixed_point_error_mn

    error = fixed_point_error_mn(network, fixed, machine, N_POSES, SEED)
    rms, largest = np.sqrt((error**2).mean()), np.abs(error).max()
    n_weights = fixed.hidden_weights.size + fixed.output_weights.size
    return (
        f"| {fixed.weight_bits} | {rms:.2f} | {largest:.1f} | {fixed.output_sum_bits} | "
        f"{n_weights * fixed.weight_bits} |"
    )

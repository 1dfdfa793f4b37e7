"""Repeat the paper's Table 2 on a real machine, from its public log of static holds, and write table2_real.md.

The log is not part of the repository: --data or GRAVCOMP_DATA names the folder that has dvrk_mtm/holds.csv.
"""

import os
import time
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp.robot.machine import load_machine
from gravcomp_lab.paper.table2_real import (
    COUNTS,
    N_HIDDEN,
    TABLE_COUNT,
    curve,
    findings,
    map_png,
    markdown,
    read_holds,
    table2_real,
)

_PAGE = """# Table 2 of the paper on a real machine

Written by `gravcomp-lab table2-real --seed {seed} --counts {counts}`, in {seconds:.0f} s of processor time on one core.

The machine is the master arm of a da Vinci Research Kit, six joints; the log has {n} static holds of it, each pose
approached with all joints moving up and moving down, mean of ten repeats (repeatability 0.2 mNm), and is public (the
repositories DNN_gravity_compensation and dvrk-gravity-compensation). It is not part of this repository.
`weights/dvrk_mtm` has the arm's published kinematics and CAD masses: the analytic model.

{table_count} holds, drawn by seed, teach; all {n_test} others judge. Every row is the bit-true core, six axes, {hidden}
neurons, compensator included. A percentage is 100 |E|/|F_exp| of a hold, norms over the joints, maximum and average; a
hold with hardly any effort has a large one, so the next columns are in percent of the RMS effort. "paper" is printed in
the paper, for its own robot at torsion 0.

{table}
- *analytic model*: the network trained on the statics of the CAD masses; it has seen no hold.
- *network, trained on the field*: random neurons, trained on the holds alone.
- *network, trained in simulation, tuned on the field*: the analytic model's network, trained on with the holds.
  Both are held near their start by a ridge that cross-validation on the holds chooses.
- *analytic model + effects found*: what the diagnosis found in the holds, in network and compensator, as after
  `make loop`.

## Error against the number of holds

Average error in percent of the RMS effort, on all holds that did not teach.

{curve}
What the diagnosis found:

{findings}
## Where the errors are

Mean size of the error, mNm, by the poses of pairs of joints; above the analytic model, below with what was found in
{table_count} holds.

![maps of both errors over the poses](figures/table2_real.png)
"""


def add_arguments(parser):
    parser.add_argument("--data", type=Path, help="folder of the measured data (default: GRAVCOMP_DATA)")
    parser.add_argument("--seed", type=int, default=1, help="of holds, poses, folds (default %(default)s)")
    parser.add_argument("--counts", type=int, nargs="+", default=list(COUNTS), help="numbers of holds of the curve")
    parser.add_argument("--robot", type=Path, default=Path("weights/dvrk_mtm"), help="machine (default %(default)s)")
    parser.add_argument("--docs", type=Path, default=Path("docs/measured"), help="folder (default %(default)s)")


def run(arguments):
    folder = arguments.data or (Path(os.environ["GRAVCOMP_DATA"]) if os.environ.get("GRAVCOMP_DATA") else None)
    if folder is None:
        raise InputError("the log is not part of the repository; name its folder by --data or GRAVCOMP_DATA")
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed} is negative; give 0 or more")
    machine = load_machine(arguments.robot)
    data = read_holds(folder, machine)
    counts = sorted({*arguments.counts, TABLE_COUNT})
    if not 20 <= counts[0] <= counts[-1] <= len(data.t_s) // 2:
        raise InputError(f"--counts: {counts[0]} .. {counts[-1]}; give 20 to {len(data.t_s) // 2}")
    began = time.process_time()
    table = table2_real(machine, data, arguments.seed, counts)
    page = _PAGE.format(
        seed=arguments.seed, counts=" ".join(map(str, arguments.counts)), seconds=time.process_time() - began,
        n=len(data.t_s), n_test=len(data.t_s) - TABLE_COUNT, table_count=TABLE_COUNT, hidden=N_HIDDEN,
        table=markdown(table), curve=curve(table), findings=findings(table),
    )  # fmt: skip
    write_all_atomically({
        arguments.docs / "table2_real.md": page, arguments.docs / "figures" / "table2_real.png": map_png(table)
    })  # fmt: skip
    print(markdown(table), curve(table), findings(table), sep="\n")
    print(f"{arguments.docs / 'table2_real.md'}: seed {arguments.seed}")

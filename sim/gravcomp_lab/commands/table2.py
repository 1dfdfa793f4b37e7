"""Repeat the paper's Table 2 on the virtual prototype and write table2.md: errors of the models on the field."""

import time
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.paper.table2 import SampleCounts, findings, markdown, table2

_HEADER = """# Table 2 of the paper, repeated

Written by `gravcomp-lab table2 --seed {seed}`, in {seconds:.0f} s of processor time on one core. Errors are in percent
of the measured force, 100 |E|/|F_exp| per pose, maximum and average over {test} test poses at each torsion that no fit
has seen. "paper" is printed in the paper; the other columns are ours, for two ways of approaching a pose: from a random
side that moves every joint (random), and always moving outward from home.

"""
_TEXT = """
## What was done

The robot is the virtual prototype. It has what the paper names, friction in the passive joints, static friction,
deformation and play, at sizes which make the analytic model err on average about as much as in the paper at torsion 0.
A PID brings it to a pose along the last millimetres and holds it; the force is read from noisy currents, the position
from quantised encoders. {training} such holds, spread over the workspace, are the field data.

- *network, trained on the field*: the network from simulation, trained on with the {training} holds. These are
  {equations} equations for 143 weights, so the weights are held near those from simulation by a ridge. Two ways were
  tried, the output layer alone and all weights; way and ridge are chosen by ten-fold cross-validation on the holds.
- *network, trained in simulation*, *analytic model*: neither has seen the prototype.
- *analytic model + effects found in ...*: the diagnosis got the log, as CSV, and no word of what is in it. Slow motion
  is another log of {motion} samples, which is what the paper's conclusion asks for.
- *core after the loop*: the bit-true model of the FPGA's network and compensator. What was found to act at rest went
  into the statics, on which the network was trained again; friction went into the compensator's constants of each axis.
  Friction in a passive joint depends on the speeds of all axes: the compensator has its mean on each axis, the rest of
  it is lost. Play is lost whole.
- *analytic model + the prototype's own effects*: the true equations with the true numbers. It shows what is left when
  friction is taken as fully developed, though at rest it may be anything up to that.

{findings}
## How to read it

- A network sees positions only. If a pose is approached from a random side, the sign of friction has nothing to do with
  the pose, and no network can learn it: training on the field then gains nothing. If poses are always approached moving
  outward from home, friction is a function of the pose and the network learns it, but what it has learned is wrong for
  every other approach. The paper does not say how its poses were approached. Its gain lies between the two.
- Models with friction are told the velocity at the end of the approach; the networks and the analytic model are not.
  In the hardware the compensator gets it from the encoders. Once the robot rests, the speed meter has no direction and
  the dead band takes friction back to zero: the rows of the core stand for the end of the approach.
- Names found in holds should be read with care: a hold shows one direction at nearly one speed, and effects that look
  alike there are listed as such. A fit can also be good under a wrong name: the prototype has no viscous friction.

## Where it differs from the paper

- The prototype stands for the paper's machine: the sizes of its effects were set once, to the average error of the
  analytic model. Maxima, and how errors grow towards torsion 15 deg, are not fitted, and are smaller than the paper's.
- The paper does not give the number of its test poses; a maximum grows with it.
- The paper does not say how the weights were started on the field. Here it is the network from simulation.
"""


def add_arguments(parser):
    parser.add_argument("--seed", type=int, default=1, help="of poses, approaches, noise, folds (default %(default)s)")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="network trained in simulation")
    parser.add_argument("--out", type=Path, default=Path("docs/measured/table2.md"), help="file (default %(default)s)")


def run(arguments):
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed} is negative; give 0 or more")
    began, began_cpu = time.monotonic(), time.process_time()
    sizes = SampleCounts()
    table = table2(load_machine(arguments.weights), load_network(arguments.weights), arguments.seed, sizes)
    seconds, cpu_seconds = time.monotonic() - began, time.process_time() - began_cpu
    header = _HEADER.format(seed=arguments.seed, seconds=cpu_seconds, test=sizes.test)
    text = _TEXT.format(
        training=sizes.training, equations=3 * sizes.training, motion=sizes.motion, findings=findings(table)
    )
    write_atomically(arguments.out, header + markdown(table) + text)
    print(markdown(table))
    print(findings(table))
    print(f"{arguments.out}: seed {arguments.seed}, {seconds:.0f} s ({cpu_seconds:.0f} s of processor time)")

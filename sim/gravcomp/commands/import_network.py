"""Take a network of one hidden layer from an ONNX file, with tanh or sigmoid, and train it further to the hardware.

Inputs: the axes' positions in m or rad, or sine and cosine, in the order of robot.toml; outputs: efforts in N or Nm.
The error of each step is printed, on poses of the statics of robot.toml or of --data that training has not seen.
"""

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("network", type=Path, metavar="ONNX", help="file of the network")
    parser.add_argument("--robot", type=Path, required=True, metavar="FOLDER", help="machine folder with robot.toml")
    parser.add_argument("--data", type=Path, metavar="CSV", help="poses and efforts to train on, in place of statics")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="machine folder to write")
    parser.add_argument("--seed", type=int, default=1, help="of poses (default %(default)s)")
    parser.add_argument("--poses", type=int, default=3500, help="training poses (default %(default)s)")


def run(arguments):
    from gravcomp.core.compensation import no_compensation
    from gravcomp.core.folder import MachineFolder, save_folder
    from gravcomp.core.provenance import write_provenance
    from gravcomp.files import check_folder
    from gravcomp.network.onnx_file import read_onnx
    from gravcomp.robot.machine import HARDWARE_ACTIVATION, load_machine
    from gravcomp.training.importing import import_network
    from gravcomp.training.samples import machine_of_samples
    from gravcomp.training.training import evaluate, training_and_test_set

    check_folder(arguments.out)
    layers = read_onnx(arguments.network)
    machine = machine_of_samples(arguments.robot, arguments.data) if arguments.data else load_machine(arguments.robot)
    machine = machine.with_activation(HARDWARE_ACTIVATION)
    data, unseen = training_and_test_set(arguments.poses, machine.robot, arguments.seed)
    network, steps = import_network(layers, machine, data, unseen, str(arguments.network))
    save_folder(arguments.out, MachineFolder(machine, network, no_compensation(machine.n_axes)))
    command = f"gravcomp import-network {arguments.network.name} --out {arguments.out} --seed {arguments.seed}"
    sources = {"poses": len(data.q), "seed": arguments.seed, "sha256": data.hash(), "test_poses": len(unseen.q)}
    metrics = evaluate(network, data, unseen)
    write_provenance(arguments.out, command=command, data=sources, metrics=metrics, machine=machine)
    print(f"{arguments.out}: {network.n_hidden} neurons; error in % of the RMS effort, {len(unseen.q)} unseen poses")
    for step, percent in steps.items():
        print(f"  {step:44} {percent:.4g}")

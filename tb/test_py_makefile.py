"""The Makefile: a path with a space stays one argument."""

import shlex
import subprocess

import pytest

from codes import ROOT


def commands(target: str, **variables: str) -> list[list[str]]:
    """The commands that make would start, as the shell splits them."""
    call = ["make", "-n", "-C", str(ROOT), target, *(f"{name}={value}" for name, value in variables.items())]
    text = subprocess.run(call, capture_output=True, text=True, check=True).stdout.replace("\\\n", " ")
    return [shlex.split(line) for line in text.splitlines() if "gravcomp " in line]


@pytest.mark.parametrize("target", ["sim", "rom", "formats", "loop"])
def test_weights_folder_may_have_a_space(target):
    calls = [call for call in commands(target, WEIGHTS="weights/my robot") if "--weights" in call]
    assert calls
    assert all(call[call.index("--weights") + 1] == "weights/my robot" for call in calls)


def test_loop_takes_log_and_folders_with_spaces():
    (call,) = (
        c for c in commands("loop", DATA="my log.csv", WEIGHTS="weights/my robot", SAVE="weights/my own") if "loop" in c
    )
    assert call[1:3] == ["loop", "my log.csv"]
    assert call[call.index("--weights") + 1] == "weights/my robot"
    assert call[call.index("--save") + 1] == "weights/my own"


@pytest.mark.parametrize("makefile", [ROOT / "Makefile", ROOT / "sim/gravcomp/project/Makefile"])
@pytest.mark.parametrize(("given", "neurons"), [([], "20"), (["HIDDEN=128"], "128")])
def test_train_takes_the_number_of_neurons(makefile, given, neurons):
    call = ["make", "-n", "-C", str(ROOT), "-f", str(makefile), "train", *given]
    text = subprocess.run(call, capture_output=True, text=True, check=True).stdout
    (train,) = (line for line in text.splitlines() if "train --robot" in line)
    words = shlex.split(train)
    assert words[words.index("--hidden") + 1] == neurons


def test_loop_without_a_folder_to_keep_asks_for_none():
    (call,) = (call for call in commands("loop") if "loop" in call)
    assert "--save" not in call

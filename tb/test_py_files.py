"""Files are written whole or not at all."""

import errno
import io
import os
import stat
from pathlib import Path

import pytest

from gravcomp import files
from gravcomp.cli import main
from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically, write_atomically


def test_written_file_replaces_the_old_one_and_leaves_nothing_else(tmp_path):
    path = tmp_path / "new" / "file.txt"
    write_atomically(path, "old")
    write_atomically(path, b"new")
    assert path.read_text() == "new"
    assert list(path.parent.iterdir()) == [path]


def test_of_several_files_all_are_replaced_or_none(tmp_path):
    first, second = tmp_path / "first.txt", tmp_path / "second.txt"
    first.write_text("old")
    second.mkdir()
    with pytest.raises(InputError, match=r"second\.txt"):
        write_all_atomically({first: "new", second: "new"})
    assert first.read_text() == "old"
    assert sorted(tmp_path.iterdir()) == [first, second]


@pytest.mark.parametrize("when", ["write", "close"])
def test_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, when):
    """Buffered bytes meet the full disk when the file is closed."""

    def full(file, *_):
        if when == "close":
            io.FileIO.close(file)
        raise OSError(errno.ENOSPC, "No space left on device")

    path = tmp_path / "report.json"
    path.write_text("old")
    monkeypatch.setattr(files, "open", type("Full", (io.FileIO,), {when: full}), raising=False)
    with pytest.raises(InputError, match=r"report\.json: cannot be written \(No space left"):
        write_all_atomically({path: "new", tmp_path / "model.toml": "new"})
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_file_in_place_of_a_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(Path(tmp_path / "file" / "inside.txt"), "text")


def test_measure_without_a_file_name_is_refused_in_one_line(capsys):
    robot = ["--robot", "weights/spheiro"]
    assert main(["measure", *robot, "--effect", "none", "--out", "", "--points", "2", "--mode", "static"]) == 2
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith("gravcomp measure:")


def test_device_and_pipe_are_not_replaced_by_a_file(tmp_path):
    """A rename would: as root over /dev/full or /dev/stdout, for the whole machine."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "out").symlink_to("/dev/null")
    for name in ("pipe", "out"):
        with pytest.raises(InputError, match=f"{name}: cannot be written .it is no file, but a device or a pipe"):
            write_atomically(tmp_path / name, "text")
    assert stat.S_ISFIFO((tmp_path / "pipe").lstat().st_mode)
    assert (tmp_path / "out").is_symlink()
    assert len(list(tmp_path.iterdir())) == 2

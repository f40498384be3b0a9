"""The folder of an autosave keeps a commit as a whole or not at all, whatever becomes of the program or the disk."""

import os
import shutil
import stat
import subprocess
import sys
from dataclasses import replace

import pytest

from ilf.errors import ExportError, FormatError, InputError
from ilf.project.recovery import find_recoverable_work
from ilf.project.store import FolderInUse, WorkFolder, WorkHeader, lock_of


@pytest.fixture
def path(tmp_path):
    return tmp_path / "autosave" / "one.work"


@pytest.fixture
def folder(path):
    made = WorkFolder(path)
    yield made
    made.close()


def test_says_whose_work_it_is(folder, path):
    header = WorkHeader("/projects/room.ilf", unsaved=False, frames=("a1",))
    folder.commit({"frames/a1.json": b"{}"}, header=header)
    folder.close()
    again = WorkFolder(path)
    assert again.header == replace(header, changed=again.header.changed)
    assert again.read("frames/a1.json") == b"{}"
    again.discard()
    assert not path.exists()


def test_it_is_another_windows_until_that_ends(folder, path):
    with pytest.raises(FolderInUse):
        WorkFolder(path)
    assert find_recoverable_work(path.parent) == []
    folder.commit({"frames/1.json": b"{}"})
    folder.close()
    (left,) = find_recoverable_work(path.parent)
    left.release()


@pytest.mark.parametrize("fails", range(3))
def test_a_commit_that_does_not_end_changes_nothing(folder, path, monkeypatch, fails):
    folder.commit({"frames/1.json": b"old", "arrays/1.zip": b"1"})
    calls, move = [], os.replace

    def full(source, target):
        calls.append(target)
        if len(calls) > fails:
            raise OSError(28, "No space left on device")
        move(source, target)

    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", full)
        with pytest.raises(ExportError, match="disk is full"):
            folder.commit({"frames/1.json": b"new", "arrays/2.zip": b"2"}, drop=["arrays/1.zip"])
    assert {name: folder.read(name) for name in folder.names()} == {"frames/1.json": b"old", "arrays/1.zip": b"1"}
    assert len(list(path.iterdir())) == 4, "nothing of it stays"
    folder.commit({"frames/1.json": b"new", "arrays/2.zip": b"2"}, drop=["arrays/1.zip"])
    assert {name: folder.read(name) for name in folder.names()} == {"frames/1.json": b"new", "arrays/2.zip": b"2"}
    assert len(list(path.iterdir())) == 4


_KILLED = """
import os, sys
from ilf.project.store import WorkFolder
folder, move, left = WorkFolder(sys.argv[1]), os.replace, [int(sys.argv[2])]
folder.commit({"frames/1.json": b"old", "project.json": b"old"})
def replace(source, target):
    if not left[0]:
        os._exit(9)
    left[0] -= 1
    move(source, target)
os.replace = replace
folder.commit({"frames/1.json": b"new", "project.json": b"new"})
os._exit(9)
"""


@pytest.mark.parametrize(("moves", "found"), [(0, b"old"), (2, b"old"), (3, b"new")])
def test_a_killed_program_leaves_one_state_or_the_other(path, moves, found):
    subprocess.run([sys.executable, "-c", _KILLED, path, str(moves)], check=False)
    folder = WorkFolder(path)
    assert {folder.read(name) for name in folder.names()} == {found}
    assert len(list(path.iterdir())) == 4, "what was being written is removed"
    folder.discard()


def test_a_folder_that_was_taken_away_is_noticed(folder, path):
    folder.commit({"frames/1.json": b"old"})
    shutil.rmtree(path)
    with pytest.raises(ExportError, match="no longer exists"):
        folder.commit({"frames/1.json": b"new"})
    assert not folder.is_there


def test_damage_is_told_of(folder, path):
    folder.commit({"frames/1.json": b"one", "frames/2.json": b"two"})
    next(path.glob("1-*.json")).write_bytes(b"0ne")
    with pytest.raises(FormatError, match="damaged"):
        folder.read("frames/1.json")
    assert folder.read("frames/2.json") == b"two"
    with pytest.raises(InputError, match="no part"):
        folder.read("frames/3.json")


@pytest.mark.parametrize(
    "index", [b"{", b"[]", b'{"schema": 0}', b'{"schema": 1, "header": {}}', b'{"schema": 1, "parts": {"a": "../b"}}']
)
def test_an_index_that_cannot_be_read_is_said_and_left_as_it_is(folder, path, index):
    folder.commit({"frames/1.json": b"one"})
    folder.close()
    (path / "index.json").write_bytes(index)
    before = sorted(path.iterdir())
    with pytest.raises(InputError):
        WorkFolder(path)
    (left,) = find_recoverable_work(path.parent)
    assert left.problem
    assert sorted(path.iterdir()) == before
    left.discard()
    assert not path.exists()


@pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")
def test_no_other_user_may_read_it(folder, path):
    folder.commit({"frames/1.json": b"{}"})
    assert stat.S_IMODE(path.stat().st_mode) == 0o700


def test_a_project_has_one_window(tmp_path):
    ours = lock_of(tmp_path / "room.ilf", tmp_path / "locks")
    assert lock_of(tmp_path / "." / "room.ilf", tmp_path / "locks") is None
    ours.release()
    again = lock_of(tmp_path / "room.ilf", tmp_path / "locks")
    again.release()

"""Sets of files: all or none, also when the process that writes them dies half way."""

import gc
import os
import signal
import warnings

import pytest

from ilf._runtime.writing import (
    check_writable,
    interrupted,
    move_into_place,
    restore_interrupted,
    staging,
    temporary_name,
)
from ilf.errors import ExportError

from ..small_runs import contents

NAMES = ("a", "b", "seal")


def write_set(target, text):
    with staging(target) as folder:
        for name in NAMES:
            (folder / name).write_text(text + name)
        move_into_place(folder, target, NAMES)


def die_in_the_middle(target, moves, after_them=False):
    """Write a set in another process, which is killed after so many moves: before the next, or as the last ends."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # other threads do nothing that the child needs
        child = os.fork()
    if child == 0:
        gc.disable()  # objects of Qt, of tests before, cannot be collected in a copy of the process
        try:
            _write_and_die(target, moves, after_them)
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _write_and_die(target, moves, after_them):
    real, done = os.replace, []

    def replace(*paths):
        if len(done) == moves:
            os.kill(os.getpid(), signal.SIGKILL)
        done.append(paths)
        real(*paths)
        if after_them and len(done) == moves:
            os.kill(os.getpid(), signal.SIGKILL)

    os.replace = replace
    write_set(target, "new ")


def test_a_set_replaces_the_one_before(tmp_path):
    write_set(tmp_path, "old ")
    (tmp_path / "other").write_text("mine")
    write_set(tmp_path, "new ")
    assert contents(tmp_path) == {"a": b"new a", "b": b"new b", "seal": b"new seal", "other": b"mine"}


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
@pytest.mark.parametrize("moves", range(7))
def test_what_a_killed_process_has_begun_is_undone_by_the_next(tmp_path, moves):
    write_set(tmp_path, "old ")
    before = contents(tmp_path)
    assert die_in_the_middle(tmp_path, moves) < 0
    (left,) = interrupted(tmp_path)
    if 0 < moves < 6:
        assert not (tmp_path / "seal").exists(), "nothing may pass for a whole set"
    restore_interrupted(tmp_path)
    assert not left.exists()
    assert contents(tmp_path) == before


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
def test_a_set_that_was_moved_whole_before_its_process_died_stays(tmp_path):
    write_set(tmp_path, "old ")
    assert die_in_the_middle(tmp_path, 7, after_them=True) < 0
    assert interrupted(tmp_path) == []
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {name: f"new {name}".encode() for name in NAMES}


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
@pytest.mark.parametrize("moves", range(4))
def test_whoever_dies_while_undoing_leaves_what_can_be_undone(tmp_path, monkeypatch, moves):
    """A set with a file that the one before did not have, left when all but the seal had been moved."""
    (tmp_path / "a").write_text("old a")
    (tmp_path / "seal").write_text("old seal")
    die_in_the_middle(tmp_path, 4)  # the old seal and the old a out, the new a and b in
    real, done = os.replace, []

    def dies(*paths):
        if len(done) == moves:
            raise KeyboardInterrupt
        done.append(paths)
        real(*paths)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", dies)
        with pytest.raises(KeyboardInterrupt):
            restore_interrupted(tmp_path)
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {"a": b"old a", "seal": b"old seal"}


def left_behind(target):
    """A temporary folder as a process leaves it that dies when the old seal and the old a have been put aside."""
    folder = target / temporary_name(".ilf-export-").replace(f"-{os.getpid()}-", "-999999999-")
    folder.mkdir(parents=True)
    for number, name in ((0, "a"), (2, "seal")):
        (folder / f".old-00{number}-{name}").write_text("old " + name)
    (folder / ".new-001-b").touch()
    return folder


def test_names_that_lead_elsewhere_move_nothing(tmp_path):
    folder = left_behind(tmp_path)
    for name in (".old-003-..", ".old-003-.", ".new-003-..", ".old-3-a"):
        (folder / name).touch()
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {"a": b"old a", "seal": b"old seal"}


def names_in(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def test_links_to_folders_are_not_followed(tmp_path):
    """Who may write into a shared folder could have files of other folders moved into it."""
    target = tmp_path / "shared"
    linked = left_behind(target)
    private = linked.rename(tmp_path / "private")
    linked.symlink_to(private)
    before = sorted(private.rglob("*"))
    restore_interrupted(target)
    assert names_in(target) == set()
    write_set(target, "new ")
    assert names_in(target) == set(NAMES)
    assert sorted(private.rglob("*")) == before
    assert linked.is_symlink()
    assert interrupted(target) == []


def test_folders_of_other_users_are_left_alone(tmp_path, monkeypatch):
    folder = left_behind(tmp_path)
    assert interrupted(tmp_path) == [folder]
    monkeypatch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1, raising=False)
    assert interrupted(tmp_path) == []
    restore_interrupted(tmp_path)
    assert (folder / ".old-000-a").read_bytes() == b"old a"
    assert names_in(tmp_path) == set()


def test_folders_of_processes_that_live_or_are_elsewhere_are_left_alone(tmp_path):
    with staging(tmp_path) as folder:
        assert interrupted(tmp_path) == []
        elsewhere = tmp_path / folder.name.replace(f"-{os.getpid()}-", "-elsewhere-1-")
        elsewhere.mkdir()
        named = tmp_path / ".ilf-export-mine"
        named.mkdir()
        restore_interrupted(tmp_path)
        assert folder.is_dir()
        assert elsewhere.is_dir()
        assert named.is_dir()


@pytest.mark.parametrize("host", ["lab-pc_1.local", ""])
def test_a_temporary_folder_names_computer_and_process(tmp_path, monkeypatch, host):
    monkeypatch.setattr("socket.gethostname", lambda: host)
    with staging(tmp_path) as folder:
        assert interrupted(tmp_path) == []
        dead = tmp_path / folder.name.replace(f"-{os.getpid()}-", f"-{2**22 + 1}-")
        dead.mkdir()
        assert interrupted(tmp_path) == [dead]
        dead.with_name(folder.name.replace(f"-{os.getpid()}-", f"-{2**22 + 2}-")).write_text("a file, not a folder")
        assert interrupted(tmp_path) == [dead]
    assert not folder.exists()


def test_old_files_that_cannot_be_put_back_are_kept(tmp_path, monkeypatch):
    write_set(tmp_path, "old ")
    real, moves = os.replace, []

    def fails_from_the_third_on(*paths):
        moves.append(paths)
        if len(moves) > 2:
            raise PermissionError(13, "in use by another program")
        real(*paths)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fails_from_the_third_on)
        with pytest.raises(ExportError, match="in use"):
            write_set(tmp_path, "new ")
    (folder,) = tmp_path.glob(".ilf-export-*")
    assert not (tmp_path / "seal").exists()
    # as if the process had ended since
    folder.rename(tmp_path / folder.name.replace(f"-{os.getpid()}-", "-999999999-"))
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {name: f"old {name}".encode() for name in NAMES}


def test_a_folder_that_was_made_for_nothing_is_unmade(tmp_path):
    with pytest.raises(KeyError), staging(tmp_path / "new" / "deep"):
        raise KeyError
    assert list(tmp_path.iterdir()) == []
    told = r"Could not write into .*new: the disk is full\. Check"
    with pytest.raises(ExportError, match=told), staging(tmp_path / "new"):
        raise OSError(28, "no space")


def test_where_not_even_the_drive_is_there_nothing_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr("os.path.exists", lambda _: False)
    with pytest.raises(ExportError, match=r"Nothing can be written into .*absent"):
        check_writable(tmp_path / "absent")

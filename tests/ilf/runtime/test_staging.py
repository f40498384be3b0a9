"""Sets of files: all or none, also when the process that writes them dies half way."""

from __future__ import annotations

import os
import re
import signal
import warnings

import pytest

from ilf._runtime import temporary_files as left_over
from ilf._runtime.staging import interrupted, move_into_place, restore_interrupted, staging
from ilf._runtime.temporary_files import unique_tag
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
@pytest.mark.parametrize("moves", range(6))
def test_what_a_killed_process_has_begun_is_undone_by_the_next(tmp_path, moves):
    write_set(tmp_path, "old ")
    before = contents(tmp_path)
    assert die_in_the_middle(tmp_path, moves) < 0
    (left,) = interrupted(tmp_path)
    if moves > 0:
        assert not (tmp_path / "seal").exists(), "nothing may pass for a whole set"
    restore_interrupted(tmp_path)
    assert not left.exists()
    assert contents(tmp_path) == before


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
def test_a_set_that_was_moved_whole_before_its_process_died_stays(tmp_path):
    write_set(tmp_path, "old ")
    assert die_in_the_middle(tmp_path, 6, after_them=True) < 0
    assert len(interrupted(tmp_path)) == 1
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {name: f"new {name}".encode() for name in NAMES}


@pytest.mark.parametrize("moves", range(4))
def test_whoever_dies_while_undoing_leaves_what_can_be_undone(tmp_path, monkeypatch, moves):
    """A set with a file that the one before did not have, left when all but the seal had been moved."""
    (tmp_path / "a").write_text("old a")
    (tmp_path / "seal").write_text("old seal")
    left = tmp_path / f".ilf-export-{unique_tag()}".replace(f"-{os.getpid()}-", f"-{2**22 + 1}-")
    real, done = os.replace, []

    def dies(*paths):
        if len(done) == limit:
            raise KeyboardInterrupt
        done.append(paths)
        real(*paths)

    limit = 4  # the old seal and the old a out, the new a and b in
    monkeypatch.setattr(os, "replace", dies)
    monkeypatch.setattr("ilf._runtime.staging._roll_back", lambda *_: None)
    left.mkdir()
    for name in NAMES:
        (left / name).write_text("new " + name)
    with pytest.raises(KeyboardInterrupt):
        move_into_place(left, tmp_path, NAMES)
    monkeypatch.undo()
    assert contents(tmp_path / left.name / "before") == {"a": b"old a", "seal": b"old seal"}
    done.clear()
    limit = moves
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", dies)
        with pytest.raises(KeyboardInterrupt):
            restore_interrupted(tmp_path)
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {"a": b"old a", "seal": b"old seal"}


def test_old_files_of_a_whole_set_that_are_half_gone_do_not_come_back(tmp_path, monkeypatch):
    """Its process died while it cleared up."""
    write_set(tmp_path, "old ")
    with monkeypatch.context() as patch:
        patch.setattr("ilf._runtime.staging._discard", lambda folder: None)
        write_set(tmp_path, "new ")
    (left,) = tmp_path.glob(".ilf-export-*")
    (left / "before" / "seal").unlink()
    left.rename(tmp_path / left.name.replace(f"-{os.getpid()}-", "-999999999-"))
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {name: f"new {name}".encode() for name in NAMES}


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
@pytest.mark.parametrize("names", [b"../user\nseal", b"x\xff", b"x" * 5000, b"a\0", b"..", b"", b"sub/user"])
def test_a_damaged_list_of_names_moves_no_other_file(tmp_path, names):
    target = tmp_path / "out"
    die_in_the_middle(target, moves=2)
    (begun,) = interrupted(target)
    (begun / ".names").write_bytes(names)
    (tmp_path / "user").write_text("mine")
    (target / "sub").mkdir()
    (target / "sub" / "user").write_text("mine")
    restore_interrupted(target)
    assert (tmp_path / "user").read_text() == (target / "sub" / "user").read_text() == "mine"
    assert interrupted(target) == []


def left_behind(target):
    """A temporary folder as a process leaves it that dies when the old seal and the old a have been put aside."""
    folder = target / f".ilf-export-{unique_tag()}".replace(f"-{os.getpid()}-", "-999999999-")
    (folder / "before").mkdir(parents=True)
    (folder / ".names").write_text("\n".join(NAMES))
    for name in ("a", "seal"):
        (folder / "before" / name).write_text("old " + name)
    return folder


def names_in(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def test_only_files_of_the_set_come_back(tmp_path):
    folder = left_behind(tmp_path)
    (folder / "before" / "other").write_text("of no set")
    restore_interrupted(tmp_path)
    assert names_in(tmp_path) == {"a", "seal"}
    assert contents(folder / "before") == {"other": b"of no set"}, "and nothing is lost"


def test_a_list_that_names_a_file_twice_restores_nothing(tmp_path):
    folder = left_behind(tmp_path)
    (folder / ".names").write_text("a\nseal\nseal")
    restore_interrupted(tmp_path)
    assert names_in(tmp_path) == set()
    assert names_in(folder / "before") == {"a", "seal"}, "and nothing is lost"


@pytest.mark.parametrize("link", ["", "before"])
def test_links_of_a_left_folder_are_not_followed(tmp_path, link):
    """Who may write into a shared folder could have files of other folders moved into it."""
    target = tmp_path / "shared"
    linked = left_behind(target) / link
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
    assert contents(folder / "before") == {"a": b"old a", "seal": b"old seal"}
    assert names_in(tmp_path) == set()


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
def test_the_next_set_clears_up_before_it_is_written(tmp_path):
    write_set(tmp_path, "old ")
    die_in_the_middle(tmp_path, 4)
    write_set(tmp_path, "third ")
    assert contents(tmp_path) == {name: f"third {name}".encode() for name in NAMES}


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


@pytest.mark.parametrize(("host", "named"), [("lab-pc_1.local", "lab_pc_1.local"), ("", "host")])
def test_a_temporary_folder_names_computer_and_process(tmp_path, monkeypatch, host, named):
    monkeypatch.setattr("socket.gethostname", lambda: host)
    left_over._host.cache_clear()
    with staging(tmp_path) as folder:
        assert re.match(rf"\.ilf-export-{named}(\.[0-9a-f]{{8}})?-{os.getpid()}-", folder.name)
        dead = tmp_path / folder.name.replace(f"-{os.getpid()}-", f"-{2**22 + 1}-")
        dead.mkdir()
        assert interrupted(tmp_path) == [dead]
        dead.with_name(folder.name.replace(f"-{os.getpid()}-", f"-{2**22 + 2}-")).write_text("a file, not a folder")
        assert interrupted(tmp_path) == [dead]
    assert not folder.exists()
    left_over._host.cache_clear()


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
    assert contents(folder / "before") == {"a": b"old a", "seal": b"old seal"}
    assert not (tmp_path / "seal").exists()
    # as if the process had ended since
    folder.rename(tmp_path / folder.name.replace(f"-{os.getpid()}-", "-999999999-"))
    restore_interrupted(tmp_path)
    assert contents(tmp_path) == {name: f"old {name}".encode() for name in NAMES}


def test_a_folder_that_was_made_for_nothing_is_unmade(tmp_path):
    with pytest.raises(KeyError), staging(tmp_path / "new" / "deep"):
        raise KeyError
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ExportError, match=r"Could not write into .*new: the disk is full"), staging(tmp_path / "new"):
        raise OSError(28, "no space")


def test_messages_name_the_files_final_place(tmp_path):
    with pytest.raises(ExportError) as caught, staging(tmp_path) as folder:
        raise ExportError(f"{folder / 'a'} is bad")
    assert str(caught.value) == f"{tmp_path / 'a'} is bad"

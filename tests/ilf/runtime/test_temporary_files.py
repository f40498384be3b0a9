"""What killed writers of single files have left goes with the next who writes there; what others are writing stays."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from ilf._runtime.writing import temporary_name, write_bytes
from ilf.sources.copies import temporary_folder

_DAY_S = 24 * 3600

_KILLED = """
import os, sys
from ilf._runtime.writing import atomic_path
with atomic_path(sys.argv[1]) as temporary:
    os.kill(os.getpid(), 9)
"""


def hidden(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.name.startswith(".ilf-")}


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
def test_what_a_killed_writer_has_left_goes_with_the_next(tmp_path):
    target = tmp_path / "notes.txt"
    killed = subprocess.run([sys.executable, "-c", _KILLED, target])
    assert killed.returncode == -signal.SIGKILL
    assert len(hidden(tmp_path)) == 1
    write_bytes(target, b"whole")
    assert {path.name for path in tmp_path.iterdir()} == {"notes.txt"}


def test_what_others_may_still_be_writing_stays_for_a_day(tmp_path):
    ours = temporary_name(".ilf-")
    names = {"of a living process": f"{ours}.json", "of another computer": ours.replace("-", "-elsewhere.", 1)}
    for age in (0.9, 1.1):
        folder = tmp_path / f"{age} days"
        folder.mkdir()
        for name in names.values():
            (folder / name).touch()
            written = (folder / name).stat().st_mtime - age * _DAY_S
            os.utime(folder / name, (written, written))
        write_bytes(folder / "notes.txt", b"whole")
        assert hidden(folder) == (set(names.values()) if age < 1 else set())


def test_a_folder_stays_while_its_process_uses_it(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    ours = temporary_name("ilf-days-")
    names = {"in use": ours, "left": ours.replace(f"-{os.getpid()}-", f"-{10**30}-")}
    for name in names.values():
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (0, 0))
    with temporary_folder("ilf-days-") as folder:
        assert {*tmp_path.iterdir()} == {tmp_path / names["in use"], folder}


def test_temporary_files_of_other_users_stay(tmp_path, monkeypatch):
    left = tmp_path / temporary_name(".ilf-").replace(f"-{os.getpid()}-", f"-{10**30}-")
    left.touch()
    monkeypatch.setattr(os, "geteuid", lambda: left.stat().st_uid + 1, raising=False)
    write_bytes(tmp_path / "notes.txt", b"whole")
    assert hidden(tmp_path) == {left.name}


def test_only_temporary_files_go(tmp_path):
    names = [".ilf-notes.txt", "ilf-0123456789abcdef", ".ilf-0123456789abcdefg", ".ilf-export-host-1-01234567"]
    for name in names[:3]:
        (tmp_path / name).touch()
    (tmp_path / names[3]).mkdir()
    for name in names:
        os.utime(tmp_path / name, (0, 0))
    write_bytes(tmp_path / "notes.txt", b"whole")
    assert {path.name for path in tmp_path.iterdir()} == {*names, "notes.txt"}

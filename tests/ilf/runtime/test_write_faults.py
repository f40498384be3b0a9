"""Disks that fail at any moment and writers that are killed; `python -m tests.bench.faults` and `python -m
tests.bench.kill.writers` try all of them."""

import os
import random

import pytest

from ilf._runtime.memory import check_memory, memory_limit, memory_needed, release_memory
from ilf._runtime.writing import move_into_place, staging, write_bytes
from ilf.errors import ExportError, FormatError, ParameterError
from tests.bench.faults import faults_of
from tests.bench.kill.writers import kills_of
from tests.bench.writers import WRITERS, Writer


@pytest.mark.parametrize(("name", "every"), [("run", 46), ("cloud", 9), ("project", 7), ("sample", 7), ("preset", 3)])
def test_a_disk_that_fails_leaves_the_old_set_or_the_new(tmp_path, name, every):
    tried, wrong = faults_of(WRITERS[name], tmp_path, every, first=random.randrange(every))
    assert tried
    assert wrong == []


def write_in_place(target, version):
    target.mkdir(exist_ok=True)
    for name in "ab":
        (target / name).write_bytes(bytes([version]) * 100_000)


def test_a_writer_that_writes_in_place_is_found_out(tmp_path):
    assert faults_of(Writer("in place", lambda folder: write_in_place), tmp_path)[1]


def _as_a_set(path, content):
    with staging(path.parent) as folder:
        write_bytes(folder / path.name, content)
        move_into_place(folder, path.parent, [path.name])


@pytest.mark.parametrize("write", [write_bytes, _as_a_set])
def test_a_write_protected_file_is_not_replaced(tmp_path, write):
    path = tmp_path / "depth.npy"
    path.write_bytes(b"mine")
    path.chmod(0o400)
    if os.access(path, os.W_OK):
        pytest.skip("this user may write any file")
    with pytest.raises(ExportError, match=r"depth\.npy is write-protected"):
        write(path, b"new")
    assert [(one, one.read_bytes()) for one in tmp_path.iterdir()] == [(path, b"mine")]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
@pytest.mark.parametrize("write", [write_bytes, _as_a_set])
def test_a_pipe_is_not_replaced_by_a_file(tmp_path, write):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    for path in (tmp_path / "pipe", tmp_path / "link"):
        with pytest.raises(ExportError, match="device or a pipe"):
            write(path, b"new")
    assert (tmp_path / "link").is_fifo()


@pytest.mark.skipif(os.name != "posix", reason="forks")
@pytest.mark.parametrize("name", ["run", "sample", "project"])
def test_a_writer_that_is_killed_leaves_a_whole_set(tmp_path, name):
    found, wrong = kills_of(WRITERS[name], tmp_path, 4, random.Random())
    assert wrong == []
    assert found.total() == 4


def test_free_memory_is_given_back_after_large_work(monkeypatch):
    asked: list[int] = []
    monkeypatch.setattr("ilf._runtime.memory._trim", lambda: asked.append)
    release_memory(640 * 480)
    assert asked == []
    release_memory(1920 * 1080)
    assert asked == [0]
    monkeypatch.setattr("ilf._runtime.memory._trim", lambda: None)
    release_memory(1920 * 1080)


def test_memory_is_estimated_against_a_limit_that_can_be_raised(monkeypatch):
    monkeypatch.delenv("ILF_MEMORY", raising=False)
    assert memory_limit() == 8e9
    check_memory("a", 9000, 6500)
    monkeypatch.setenv("ILF_MEMORY", str(memory_needed(1920, 1080) / 1e9))
    check_memory("a", 1920, 1080)
    with pytest.raises(FormatError, match=r"1921 x 1080 .* 1\.2 GB of memory, but only 1\.19\d* GB .*ILF_MEMORY=1\.2 "):
        check_memory("a", 1921, 1080)
    monkeypatch.setenv("ILF_MEMORY", "0.35")
    with pytest.raises(FormatError, match=r"160 x 120 pixels.* 0\.375 GB of memory, but only 0\.35 GB are"):
        check_memory("a", 160, 120)
    for wrong in ("much", "-1", "nan"):
        monkeypatch.setenv("ILF_MEMORY", wrong)
        with pytest.raises(ParameterError, match="must be a positive number of GB"):
            memory_limit()

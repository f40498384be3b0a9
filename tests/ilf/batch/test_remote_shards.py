"""Shards at addresses: the same files as on a disk, each put once, and resumed after failures and kills."""

import errno
import io
import json
import os
import pickle
import subprocess
import sys
import time

import numpy as np
import pytest

import ilf
import ilf._runtime.files
from ilf._runtime.addresses import RemoteFiles
from ilf._runtime.folders import folder_at
from ilf.cli import main
from ilf.errors import ExportError
from ilf.run.stored_results import StoredResults
from ilf.sources.opening import close_all

from ..object_store import SECRET, object_store
from .test_batch import FLAGS
from .test_shards import command, tars

fsspec = pytest.importorskip("fsspec")
parquet = pytest.importorskip("pyarrow.parquet")

OUT = "memory://results/out"


@pytest.fixture
def memory():
    """An empty store."""
    store = fsspec.filesystem("memory")
    store.store.clear()
    store.pseudo_dirs[:] = [""]
    yield store
    close_all()


def tars_at(store, folder):
    return {path.rpartition("/")[2]: store.cat(path) for path in store.glob(f"{folder}/*.tar")}


def without_tars(upload):
    def checked(files, path, name):
        if name.endswith(".tar"):
            raise ExportError("no route")
        upload(files, path, name)

    return checked


def failing_request():
    raise ConnectionError("no route")


def staged(tmp_path):
    return [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]


def test_shards_at_an_address_are_those_of_a_folder(source, tmp_path, memory, begun, monkeypatch, cli):
    put, real = [], RemoteFiles.upload
    monkeypatch.setattr(RemoteFiles, "upload", lambda self, path, name: put.append(name) or real(self, path, name))
    memory.put(str(source), "/data/in", recursive=True)
    assert main(command(source, tmp_path / "alone")) == 0
    assert main(command("memory://data/in", OUT)) == 0
    assert tars_at(memory, "/results/out") == tars(tmp_path / "alone")
    numbered = [f"00000{number}.{end}" for number in range(3) for end in ("tar", "parquet")]
    assert [name.rpartition("-")[2] for name in put] == ["frames.jsonl", "shards.json", *numbered]  # each once
    assert not staged(tmp_path)
    state = json.loads(cli("batch", "--shards", OUT, "--verify", "--merge", "--json").out)
    assert (state["folder"], state["finished"], state["completed"], state["problems"]) == (OUT, 3, 5, [])
    assert memory.exists("/results/out/merged.parquet")
    here, there = ilf.open_source(tmp_path / "alone"), ilf.open_source(OUT)
    assert here.keys == there.keys
    for key in here.keys:  # colour is read from the sources, there at their address
        np.testing.assert_array_equal(here[key].depth, there[key].depth)
        np.testing.assert_array_equal(here[key].rgb, there[key].rgb)
    assert there[0].inputs.rgb.path == OUT
    results = pickle.loads(pickle.dumps(StoredResults(OUT)))  # as for the workers of a DataLoader
    np.testing.assert_array_equal(results[0].depth, here[0].depth)
    assert f"{OUT}, 3 of 3 finished" in cli("info", OUT).out
    memory.pipe("/results/out/" + put[2], b"0" * 40)
    assert f"{OUT}/{put[2]} is damaged" in cli("batch", "--shards", OUT, "--verify", status=1).err


def test_a_resume_reads_the_listing_and_the_ends_of_tables(source, tmp_path, memory, begun, monkeypatch):
    assert main(command(source, OUT)) == 0
    name = memory.glob("/results/out/*0001.tar")[0].rpartition("/")[2].removesuffix(".tar")
    left = folder_at(OUT).working / "parts" / name / "000000002"  # by a kill after the table was put
    left.parent.mkdir(parents=True)
    left.write_bytes(b"{}\n")
    read = []
    for name in ("read_all", "read_ranges", "open"):
        real = getattr(RemoteFiles, name)

        def noted(self, names, *how, real=real):
            read.extend([names] if isinstance(names, str) else names)
            return real(self, names, *how)

        monkeypatch.setattr(RemoteFiles, name, noted)
    monkeypatch.setattr(RemoteFiles, "upload", lambda *_: pytest.fail("nothing is written"))
    begun.clear()
    assert main(command(source, OUT)) == 0
    assert not begun
    assert not staged(tmp_path)
    assert [name.rpartition(".")[2] for name in read] == ["json", "parquet", "parquet", "parquet"]
    assert main(command(source, OUT, "--shard", "2/3")) == 0
    assert len(read) == 4 + 2


def test_what_a_store_refuses_is_one_line_and_is_resumed(source, tmp_path, memory, begun, monkeypatch, capsys):
    real, left = type(memory).put_file, [4]

    def failing(self, *how, **more):
        left[0] -= 1
        if left[0] == 0:
            raise ConnectionError(f"https://me:{SECRET}@host timed out\nagain")
        return real(self, *how, **more)

    monkeypatch.setattr(type(memory), "put_file", failing)
    assert main(command(source, OUT)) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"Could not write {OUT}/shard-" in error
    assert "(https://host timed out again)" in error
    assert len(list(tmp_path.glob("cache/shards/*/parts/*/0*"))) == 2  # the tar is there, its table is not
    done = len(begun)
    assert main(command(source, OUT)) == 0
    assert len(begun) == 5
    assert done == 2
    assert main(command(source, tmp_path / "alone")) == 0
    assert tars_at(memory, "/results/out") == tars(tmp_path / "alone")
    with monkeypatch.context() as silent:
        silent.setattr(type(memory), "info", lambda *_, **__: failing_request())
        silent.setattr(RemoteFiles, "upload", lambda *_: pytest.fail("a list that cannot be seen is not written anew"))
        assert main(command(source, OUT)) == 1
    assert "cannot be read (no route)" in capsys.readouterr().err
    monkeypatch.setattr(type(memory), "put_file", lambda self, path, name: self.pipe(name, b""))
    assert main(command(source, "memory://results/other")) == 1
    assert "it has 0 bytes instead of" in capsys.readouterr().err


def test_a_folder_that_was_deleted_is_begun_anew(source, tmp_path, memory, begun, monkeypatch):
    with monkeypatch.context() as failing:
        failing.setattr(RemoteFiles, "upload", without_tars(RemoteFiles.upload))
        assert main(command(source, OUT)) == 1
    assert staged(tmp_path)
    memory.rm("/results/out", recursive=True)
    begun.clear()
    assert main(command(source, OUT)) == 0
    assert len(begun) == 5


def test_a_full_disk_of_this_machine_is_one_line_and_is_resumed(source, tmp_path, memory, begun, monkeypatch, capsys):
    real, left = os.fsync, [0]

    def full(number):
        left[0] -= 1
        if left[0] == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(number)

    monkeypatch.setattr(ilf._runtime.files.os, "fsync", full)
    for at in (1, 4, 6):  # the list, a part, a tar
        left[0] = at
        assert main(command(source, OUT)) == 1
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert "the disk is full" in error
        assert str(tmp_path / "cache") in error
    left[0] = 0
    assert main(command(source, OUT)) == 0
    assert len(begun) == len(set(begun)) + 1  # the frame whose part could not be written
    assert main(command(source, tmp_path / "alone")) == 0
    assert tars_at(memory, "/results/out") == tars(tmp_path / "alone")
    assert not staged(tmp_path)


# A server of S3, and processes of their own.


@pytest.fixture(scope="session")
def s3():
    """The environment of processes that use a stand-in for S3."""
    pytest.importorskip("s3fs", reason="s3fs is not installed (extra dev)")
    pytest.importorskip("moto.server", reason="moto is not installed (extra dev)")
    with object_store() as settings:
        yield settings


@pytest.fixture
def bucket(s3, monkeypatch):
    """The stand-in for S3, empty; this process and its children use it."""
    for name, value in s3.items():
        monkeypatch.setenv(name, value)
    store = fsspec.filesystem("s3", skip_instance_cache=True, use_listings_cache=False)
    if found := store.find("bucket"):
        store.rm(found)
    type(store).clear_instance_cache()  # the driver's connections have the environment of their time
    yield store
    close_all()


def test_kills_lose_nothing_at_an_address(source, tmp_path, bucket, begun):
    address, out = "s3://bucket/in", "s3://bucket/out"
    bucket.put(str(source), "bucket/in", recursive=True)
    assert main(command(source, tmp_path / "alone")) == 0
    words = [sys.executable, "-m", "ilf", *command(address, out)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        while not list(tmp_path.glob("cache/shards/*/parts/*/0*")):
            assert process.poll() is None
            time.sleep(0.002)
    finally:
        process.kill()
        told, _ = process.communicate()  # its worker, which ends with it, has the same end of the pipe
    begun.clear()
    assert main(command(address, out)) == 0
    assert 0 < len(begun) < 5
    assert tars_at(bucket, "bucket/out") == tars(tmp_path / "alone")
    assert main(["batch", "--shards", out, "--verify"]) == 0
    (tmp_path / "one").mkdir()
    assert main(["complete", address, "--frame", "0001", "--out", str(tmp_path / "one"), "--quiet", *FLAGS[:-1]]) == 0
    written = [bucket.cat(path) for path in bucket.find("bucket")]
    written += [told, *(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())]
    tables = [content for content in written if content.startswith(b"PAR1")]
    assert len(tables) == 2 * 3
    written += [str(parquet.read_table(io.BytesIO(content)).to_pydict()).encode() for content in tables]
    assert not any(SECRET.encode() in content or b"AKIAIOSFODNN7EXAMPLE" in content for content in written)
    assert json.loads((tmp_path / "one/run.json").read_text())["inputs"]["rgb"]["path"] == f"{address}/rgb/0001.png"


def test_a_store_that_does_not_answer_is_one_line(bucket, monkeypatch, cli):
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")  # nothing listens there
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    error = cli("info", "s3://bucket/in", status=1).err
    assert error.count("\n") == 1
    assert "error: s3://bucket/in/" in error
    assert ": cannot be read (Could not connect" in error
    assert SECRET not in error

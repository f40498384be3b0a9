"""Shards by the workers of a Dask cluster: the same tars, and what happens when workers or the command end."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

import ilf.batch.engine
from ilf._runtime.folders import folder_at
from ilf.batch.engine import complete_many, complete_unit
from ilf.batch.settings import BatchSettings
from ilf.batch.shard_sink import open_shards
from ilf.cli import main
from ilf.errors import InputError
from ilf.run.options import ExportOptions

from ..batch_frames import contents
from .test_batch import FLAGS, frames_in
from .test_shards import command, rows, tars

distributed = pytest.importorskip("distributed")
pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def cluster():
    """Two workers, which are threads of this process. A scheduler serves HTTP also without a dashboard: at any free
    port, since the usual one, which is a warning if taken, may be that of another process of the tests."""
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        host="127.0.0.1",
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
    ) as there:
        yield there


@pytest.fixture
def batch(source, tmp_path, begun):
    return open_shards(lambda: frames_in(source), tmp_path / "out", SETTINGS, ("depth",), 3, {})


SETTINGS = BatchSettings(options=ExportOptions(depth_formats=("png",), cloud=None))


def test_a_cluster_writes_the_same_shards_and_resumes(source, tmp_path, cluster, begun, capsys, cli):
    good = (source / "depth" / "0001.png").read_bytes()
    out, alone = tmp_path / "out", tmp_path / "alone"
    assert main(command(source, alone)) == 0
    on_cluster = [word for word in command(source, out) if word != "--quiet"] + ["--dask", cluster.scheduler_address]
    (source / "depth" / "0001.png").write_bytes(good[:40])
    assert main(command(source, out, "--shard", "2/3")) == 0
    begun.clear()
    capsys.readouterr()
    told = cli(*on_cluster, status=1)
    assert "1 of 5 frames failed. rgb/0001: " in told.err
    assert "5 frames: 2 completed, 1 failed, 2 completed before, in " in told.out
    assert sorted(begun) == ["rgb/0000", "rgb/0001", "rgb/0004"]
    (source / "depth" / "0001.png").write_bytes(good)
    assert "5 frames: 1 completed, 0 failed, 4 completed before, in " in cli(*on_cluster, "--retry-failed").out
    assert begun[3:] == ["rgb/0001"]
    assert tars(out) == tars(alone)
    assert main(["batch", "--shards", str(out), "--verify"]) == 0
    assert main(on_cluster) == 0
    assert len(begun) == 4
    assert not (out / "parts").exists()


def test_a_cluster_completes_the_same_folder_and_resumes(source, tmp_path, cluster, begun, cli):
    (source / "depth" / "0001.png").write_bytes(b"no image")
    words = ["batch", str(source), "--quiet", *FLAGS, "--out"]
    assert main([*words, str(tmp_path / "alone")]) == 1
    begun.clear()
    on_cluster = [*words, str(tmp_path / "out"), "--dask", cluster.scheduler_address]
    assert "1 of 5 frames failed. rgb/0001: " in cli(*on_cluster, status=1).err
    assert contents(tmp_path / "out") == contents(tmp_path / "alone")
    assert main(on_cluster) == 1
    assert sorted(begun) == [f"rgb/000{number}" for number in range(5)]


def test_workers_end_a_shard_that_nobody_waits_for(batch, cluster, begun, monkeypatch):
    waiting, real = [], ilf.batch.engine.complete_frame

    def slow(sink, frame, threads):
        waiting.append(frame)
        while len(waiting) < 3:  # both workers are busy until this is seen below
            time.sleep(0.01)
        return real(sink, frame, threads)

    monkeypatch.setattr(ilf.batch.engine, "complete_frame", slow)
    work = complete_many(batch, cluster=cluster.scheduler_address)
    monkeypatch.setattr(distributed, "as_completed", lambda *_, **__: until_both(waiting))
    with pytest.raises(KeyboardInterrupt):
        next(work)
    states = [worker.state.tasks for worker in cluster.workers.values()]
    while any(task.state != "cancelled" for tasks in states for task in list(tasks.values())):
        time.sleep(0.01)
    waiting.append(None)
    while any(states):
        time.sleep(0.01)
    assert len(begun) == 2, "each has ended after the frame in progress"
    assert len(list(batch.folder.working.glob("parts/*/0*"))) == 2


def until_both(waiting):
    while len(waiting) < 2:
        time.sleep(0.01)
    raise KeyboardInterrupt
    yield


@pytest.fixture
def as_worker(monkeypatch):
    """This process is a worker."""
    monkeypatch.setattr(ilf.batch.engine, "check_wanted", lambda: None)
    monkeypatch.setattr(ilf.batch.engine, "threads_of_worker", lambda: 1)


def test_a_frame_that_ends_workers_is_left_for_the_end(batch, begun, as_worker, monkeypatch):
    real = ilf.batch.engine.complete_frame

    def deadly(sink, frame, threads):
        if frame.number == 1:
            begun.append(frame.key)
            raise SystemExit
        return real(sink, frame, threads)

    def given_up(work, items, address):
        for item in items:
            for _ in range(2):
                try:
                    work(item)
                except SystemExit:
                    continue
                yield item, True
                break
            else:
                yield item, None

    def crashing(work, items, **_):
        return ((item, None if item.number == 1 else batch.done(item)) for item in items)

    monkeypatch.setattr(ilf.batch.engine, "complete_frame", deadly)
    monkeypatch.setattr(ilf.batch.engine, "run_on_cluster", given_up)
    monkeypatch.setattr(ilf.batch.engine, "run_in_processes", crashing)
    outcomes = {outcome.frame: outcome for outcome in complete_many(batch, cluster="there")}
    assert begun == ["rgb/0000", "rgb/0001", "rgb/0002", "rgb/0001", "rgb/0003", "rgb/0004"]
    assert [key for key, outcome in outcomes.items() if not outcome.is_completed] == ["rgb/0001"]
    assert "crashed twice" in outcomes["rgb/0001"].message
    assert +batch.counts == {"completed": 4, "failed": 1}
    assert [row["status"] for row in rows(Path(str(batch.folder)))] == ["completed", "failed", *["completed"] * 3]


def test_workers_that_see_or_are_something_else(batch, begun, as_worker, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"does not see the shards in .*elsewhere\. Use an output folder that all"):
        complete_unit(replace(batch, folder=folder_at(tmp_path / "elsewhere")), 0)
    with pytest.raises(InputError, match="does not see the shards"):
        complete_unit(replace(batch, shards=replace(batch.shards, sha256="other")), 0)
    monkeypatch.setattr("ilf.batch.shard_sink.facts_here", lambda settings: {"version": "other"})
    with pytest.raises(InputError, match="This machine differs in program version, networks or files"):
        complete_unit(batch, 0)
    monkeypatch.setattr(ilf.batch.engine, "run_on_cluster", lambda work, items, _: ((item, True) for item in items))
    with pytest.raises(InputError, match=r"000000\.parquet, but it is missing in .*out here"):
        next(complete_many(batch, cluster="there"))
    assert not begun

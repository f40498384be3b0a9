"""`python -m tests.bench.cluster_shards [kills] [costs] [--frames 2000] [--kills 10] [--data FOLDER...]`: Dask.

kills   generated frames of 64 x 48 and those of --data, in a stand-in for S3, are completed to there by two Dask
        workers; a worker or the command is killed (-9) at random moments, and the scheduler once. Then every frame is
        there once, and is that of a run of its own. Prints requests, files and processor time
costs   processor time, and size in the shards, of a frame of --data
"""

from __future__ import annotations

import argparse
import io
import logging
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import fsspec
import pyarrow.parquet

import ilf
from ilf._runtime.folders import Folder, folder_at
from ilf._runtime.installation import asset_path
from ilf._runtime.processes import run_units
from ilf.batch.frames import BatchFrame, frames_of_sources
from ilf.io.depth import encode_depth, encode_expected_error
from ilf.io.labels import encode_labels
from ilf.sources.shards import members_of
from tests.ilf.batch_frames import write_frames
from tests.ilf.object_store import object_store

from .batch import ILF, children, verdict
from .shards import SETTINGS, done, tables


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[Path, subprocess.Popen[bytes], subprocess.Popen[bytes]]]:
    """Run a scheduler and two workers; provides the scheduler file, the scheduler, and the nanny of the workers."""
    told = folder / "scheduler.json"
    told.unlink(missing_ok=True)

    def start(program: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{program}", "--no-dashboard", *words]
        return subprocess.Popen(
            [*command, "--scheduler-file", str(told)],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    processes = [start("scheduler", "--host", "127.0.0.1", "--port", "0")]
    try:
        while not told.exists():
            time.sleep(0.1)
        processes.insert(0, start("worker", "--nworkers", "2", "--nthreads", "1"))
        yield told, processes[1], processes[0]
    finally:
        for process in processes:
            process.terminate()
            process.wait()


class _Requests(logging.Handler):
    """Counts the requests that the stand-in for S3 logs, by their methods."""

    def __init__(self) -> None:
        super().__init__()
        self.counts = Counter[str]()

    def emit(self, record: logging.LogRecord) -> None:
        found = re.search("(GET|PUT|HEAD|POST|DELETE) ([^ ]+)", record.getMessage())
        if found is None:
            return
        self.counts["LIST" if "list-type=" in found[2] else found[1]] += 1


def alone(frame: BatchFrame) -> dict[str, bytes]:
    """Complete a frame by itself; its files by the endings of their names."""
    run = SETTINGS.configuration.make_run(frame.source.load())
    completion = run.complete(threads=1)
    units = SETTINGS.options.depth_units
    return {
        "depth.png": encode_depth("depth.png", completion.depth, units)[0],
        "expected_error.png": encode_expected_error("expected_error.png", ilf.expected_error(completion), units)[0],
        "blocks.png": encode_labels(run.blocks),
    }


def kills(folder: Path, count: int, killed: int, data: Sequence[Path]) -> bool:
    """Complete frames in a store by Dask workers; a worker or the command is killed `killed` times, and the scheduler
    once."""
    sources = [write_frames(folder / "in", count, (48, 64)), *data]
    frames, per_shard, rng = frames_of_sources([ilf.open_source(path) for path in sources]), 50, random.Random(0)
    victims = ["scheduler", *rng.choices(["worker", "command"], k=killed)]
    rng.shuffle(victims)
    requests, log, good = _Requests(), logging.getLogger("werkzeug"), []
    with object_store() as settings, ExitStack() as running:
        os.environ.update(settings, ILF_CACHE=str(folder / "cache"))
        store, addresses = fsspec.filesystem("s3"), [f"s3://bucket/{path.name}" for path in sources]
        for path, address in zip(sources, addresses, strict=True):
            store.put(str(path), address, recursive=True)
        out, used = folder_at("s3://bucket/out"), children_s()
        command = [*ILF, "batch", *addresses, "--shards", str(out), "--per-shard", str(per_shard), "--quiet", "--dask"]
        told, scheduler, nanny = running.enter_context(cluster(folder))
        log.setLevel(logging.INFO)
        log.handlers[:] = [requests]
        process = subprocess.Popen([*command, str(told)], stderr=subprocess.PIPE, text=True)
        for number, victim in enumerate(victims):
            target = len(frames) * (number + rng.random()) / len(victims)
            while (there := done(out, per_shard)) < target and process.poll() is None:
                time.sleep(0.5)
            print(f"    {there} frames are done: the {victim} is killed", flush=True)
            if victim == "worker":
                while not (workers := children(nanny.pid)):  # they are being restarted
                    time.sleep(0.1)
                os.kill(rng.choice(workers), signal.SIGKILL)
                continue
            (process if victim == "command" else scheduler).kill()
            error = process.communicate()[1]
            if victim == "scheduler":
                good.append(verdict(f"one line: {error.strip()}", process.returncode == 1 and error.count("\n") == 1))
                running.close()
                told, scheduler, nanny = running.enter_context(cluster(folder))
            process = subprocess.Popen([*command, str(told)], stderr=subprocess.PIPE, text=True)
        error = process.communicate()[1]
        good.append(verdict(f"the batch is finished {error}", process.returncode == 0))
        running.close()
        log.setLevel(logging.ERROR)
        print(f"    requests, with the listings of this test: {dict(requests.counts)}")
        each = (children_s() - used) / len(frames)
        print(f"    {each:.3f} s of processor time a frame, with starts and repeated frames")
        return all([*good, same_as_alone(out, frames)])


def children_s() -> float:
    """Processor time of the processes that this one has started and that have ended [s]."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def same_as_alone(out: Folder, frames: Sequence[BatchFrame]) -> bool:
    """Whether shards contain every frame once, and as a run of its own gives it."""
    found = []
    for name in tables(out):
        tar = out.read(f"{name.removesuffix('.parquet')}.tar")
        for row in pyarrow.parquet.read_table(io.BytesIO(out.read(name))).to_pylist():
            found.append((row["key"], members_of(tar[row["offset"] : row["offset"] + row["size"]], name)))
    once = sorted(key for key, _ in found) == sorted(frame.key for frame in frames)
    expected = dict(
        zip((frame.key for frame in frames), run_units(alone, [(one,) for one in frames], jobs=2), strict=True)
    )
    same = sum(all(files[name] == content for name, content in expected[key].items()) for key, files in found)
    sizes = out.sizes()
    print(f"    {len(sizes)} files, {sum(sizes.values()) / 1e6:.1f} MB")
    return verdict(f"{len(found)} of {len(frames)} frames, each once", once) and verdict(
        f"{same} are byte for byte those of single runs", same == len(frames)
    )


def costs(folder: Path, data: Sequence[Path]) -> bool:
    """Measure processor time and size of frames; the start is left out."""
    used, frames = [], sum(len(ilf.open_source(path)) for path in data)
    for more in (["--frames", ":1"], []):
        out, before = folder / f"out{len(used)}", children_s()
        subprocess.run([*ILF, "batch", *data, "--shards", out, "--quiet", *more], check=True)
        used.append(children_s() - before)
    size = sum(path.stat().st_size for path in out.iterdir())
    each = (used[1] - used[0]) / (frames - 1)
    print(f"{frames} frames: {each:.2f} s of processor time and {size / frames / 1e6:.3f} MB each")
    return True


def main() -> int:
    """Run the requested tests."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", choices=("kills", "costs"), default=[])
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--data", type=Path, nargs="+", default=[asset_path("samples/room")])
    options = parser.parse_args()
    tests = {
        "kills": partial(kills, count=options.frames, killed=options.kills, data=options.data),
        "costs": partial(costs, data=options.data),
    }
    good = []
    for what in options.what or tests:
        with tempfile.TemporaryDirectory() as name:
            good.append(tests[what](Path(name)))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())

"""`python -m tests.bench.shards [kills] [store-kills] [keys] [overhead] [--kills 10] [--count 100000]`: shards.

kills     the process or one of its workers is killed (-9) at random moments until the batch is done; then the tars are
          those of an undisturbed batch byte for byte, and no frame was completed twice but those in progress
store-kills  the same with sources and shards in a stand-in for S3 on this machine
keys      processor time and memory for each key of listing and freezing, of resuming with all shards finished (in a
          stand-in for S3, too, which runs in the same process), of merging and of opening the shards as a source
          and as results
overhead  processor time of encoding, measuring, writing and assembling a frame of the sample, beyond the library's
"""

from __future__ import annotations

import argparse
import io
import json
import os
import pickle
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import fsspec
import pyarrow
import pyarrow.parquet

import ilf
from ilf._runtime.files import write_bytes
from ilf._runtime.folders import Folder, folder_at
from ilf._runtime.installation import asset_path
from ilf.batch.frames import BatchFrame, frames_of_sources
from ilf.batch.settings import BatchSettings
from ilf.batch.shard_files import merge_tables, schema, write_shard
from ilf.batch.shard_task import ShardTask, _completed, _files
from ilf.batch.shards import open_shards
from ilf.batch.task import measured
from ilf.run.options import ExportOptions
from ilf.run.stored_results import StoredResults
from ilf.sources.shards import Shards
from tests.ilf.batch_frames import write_frames
from tests.ilf.object_store import object_store

from .batch import ILF, children, resident, verdict

SETTINGS = BatchSettings(options=ExportOptions(depth_formats=("png",), cloud=None))
KEEP = ("depth", "expected_error", "blocks")


def tars(out: Folder) -> dict[str, bytes]:
    """Contents of all tars."""
    return {name: out.read(name) for name in sorted(out.sizes()) if name.endswith(".tar")}


def tables(out: Folder) -> list[str]:
    """Names of all tables."""
    return [name for name in out.sizes() if name.startswith("shard-") and name.endswith(".parquet")]


def done(out: Folder, per_shard: int = 7) -> int:
    """Number of frames in parts and tables, about: the last shard counts as a whole one."""
    parts = sum(1 for path in out.working.glob("parts/*/*") if path.name.isdecimal())
    return parts + per_shard * len(tables(out))


def store_kills(folder: Path, count: int) -> bool:
    """Kill the process or a worker `count` times while sources and shards are in a store."""
    with object_store() as settings:
        os.environ.update(settings, ILF_CACHE=str(folder / "cache"))
        return kills(folder, count, at="s3://bucket")


def kills(folder: Path, count: int, frames: int = 60, at: str = "") -> bool:
    """Kill the process or a worker `count` times."""
    source, rng = str(write_frames(folder / "in", frames, (48, 64))), random.Random(0)
    out = folder_at(f"{at}/out" if at else folder / "out")
    command = [*ILF, "batch", source, "--per-shard", "7", "--jobs", "2", "--quiet", "--shards"]
    subprocess.run([*command, str(folder / "undisturbed")], check=True)
    if at:
        fsspec.filesystem("s3").put(source, "bucket/in", recursive=True)
        command[len(ILF) + 1] = source = f"{at}/in"
    killed, process = 0, subprocess.Popen([*command, str(out)])
    while killed < count:
        target = frames * (killed + rng.random()) / count
        while done(out) < target and process.poll() is None:
            time.sleep(0.05 if at else 0.005)
        if process.poll() is None:
            with suppress(ProcessLookupError):  # a worker that has just ended
                os.kill(rng.choice([process.pid, *children(process.pid)]), signal.SIGKILL)
                killed += 1
            time.sleep(0.1)
        if process.poll() is not None:
            process = subprocess.Popen([*command, str(out)])
    process.wait()
    subprocess.run([*command, str(out)], check=True)
    listed = [
        row["key"]
        for name in tables(out)
        for row in pyarrow.parquet.read_table(io.BytesIO(out.read(name))).to_pylist()
        if row["status"] == "completed"
    ]
    return all(
        [
            verdict(f"{count} kills: every frame once", sorted(listed) == sorted(ilf.open_source(source).keys)),
            verdict("tars are those of an undisturbed batch", tars(out) == tars(folder_at(folder / "undisturbed"))),
            verdict(
                "--verify finds nothing",
                subprocess.run([*ILF, "batch", "--shards", str(out), "--verify"]).returncode == 0,
            ),
            verdict("no part is left", not any(path.is_file() for path in out.working.glob("parts/**/*"))),
        ]
    )


def _listed(root: Path) -> list[BatchFrame]:
    return frames_of_sources([ilf.open_source(root)])


def _step(what: str, count: int, work: Callable[[], object]) -> None:
    before, start = resident(os.getpid()), sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    work()
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2]) - start
    print(f"{what}: {used / count * 1e6:.1f} us a key; memory {before:.0f}, then {resident(os.getpid()):.0f} MB")


def keys(folder: Path, count: int) -> bool:
    """Measure the work for each of many keys; their files are empty."""
    root, out = folder / "many", folder / "shards"
    for kind in ("rgb", "depth"):
        (root / kind).mkdir(parents=True)
        for number in range(count):
            (root / kind / f"{number:07}.png").touch()
    _step("listing", count, partial(_listed, root))
    opened = partial(open_shards, partial(_listed, root), out, SETTINGS, KEEP, 1000, {})
    _step("freezing, in this process", count, opened)
    batch = opened()
    _step("reading the frozen list", count, lambda: sum(1 for _ in batch._frames(batch.to_do, {})))
    for index in range(batch.shards.count):
        name, numbers = batch.shards.name(index), batch.shards.numbers(index)
        made = [
            {"key": f"rgb/{n:07}", "status": "completed", "message": "", "offset": 0, "size": 0, "shard": f"{name}.tar"}
            | {key: os.urandom(32).hex() for key in ("rgb_sha256", "depth_sha256", "sha256")}
            for n in numbers
        ]
        facts = {"ilf": json.dumps({"sha256": batch.shards.sha256, "tar_sha256": "", "failed": 0})}
        pyarrow.parquet.write_table(
            pyarrow.Table.from_pylist(made, schema().with_metadata(facts)), out / f"{name}.parquet"
        )
    _step("resuming, all finished", count, lambda: list(opened().outcomes()))
    with object_store() as settings:
        os.environ.update(settings)
        names = ["shards.json", "frames.jsonl", *tables(folder_at(out))]
        fsspec.filesystem("s3").put([str(out / name) for name in names], [f"bucket/out/{name}" for name in names])
        there = partial(open_shards, partial(_listed, root), "s3://bucket/out", SETTINGS, KEEP, 1000, {})
        _step("resuming in a store, with the store's own work", count, lambda: list(there().outcomes()))
    _step("merging", count, lambda: merge_tables(folder_at(out)))
    _step("opening as a source", count, lambda: Shards(out).index())
    _step("opening as results", count, lambda: StoredResults(out))
    print(f"pickled results: {len(pickle.dumps(StoredResults(out))) / count:.0f} bytes a key")
    return True


def overhead(folder: Path) -> bool:
    """Measure what a shard adds to the library's work on a frame."""
    (frame,) = frames_of_sources([ilf.open_source(asset_path("samples"))])
    task = ShardTask(str(folder), SETTINGS, KEEP, "")
    _, part = _completed(task, frame, 1)
    run = SETTINGS.configuration.make_run(frame.source.load())
    completion = run.complete(threads=1)
    error = ilf.expected_error(completion)
    for what, repeats, work in (
        ("encoding", 1, lambda: _files(task, run, completion, error)),
        ("measuring", 1, lambda: measured(SETTINGS, frame, run, completion, error, 1)),
        ("writing the part", 1, lambda: write_bytes(folder / "part", part.content())),
        ("assembling", 50, lambda: write_shard(folder_at(folder), "shard", "", [folder / "part"] * 50)),
    ):
        times = []
        for _ in range(5):
            start = time.process_time()
            work()
            times.append((time.process_time() - start) / repeats)
        print(f"{what}: {min(times) * 1000:.1f} ms; {len(part.data) / 1e6:.2f} MB a frame")
    return True


def main() -> int:
    """Run the requested tests."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", choices=("kills", "store-kills", "keys", "overhead"), default=[])
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--count", type=int, default=100_000)
    options = parser.parse_args()
    tests = {
        "kills": partial(kills, count=options.kills),
        "store-kills": partial(store_kills, count=options.kills),
        "keys": partial(keys, count=options.count),
        "overhead": overhead,
    }
    good = []
    for what in options.what or tests:
        with tempfile.TemporaryDirectory() as name:
            good.append(tests[what](Path(name)))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())

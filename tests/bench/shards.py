"""Processor time and memory for each key of a batch with shards: `python -m tests.bench.shards [--count 100000]`.

Of listing and freezing, of resuming with all shards finished (in a stand-in for S3, too, which runs in the same
process), of merging the tables, and of opening the shards as a source and as results. The files of the keys are empty.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import resource
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import fsspec
import pyarrow
import pyarrow.parquet

import ilf
from ilf._runtime.folders import folder_at
from ilf.batch.engine import complete_many
from ilf.batch.frames import BatchFrame, frames_of_sources
from ilf.batch.frozen_list import listed_frames
from ilf.batch.settings import BatchSettings
from ilf.batch.shard_files import merge_tables, schema
from ilf.batch.shard_sink import ShardSink, open_shards
from ilf.run.options import ExportOptions
from ilf.run.stored_results import StoredResults
from ilf.sources.shards import Shards
from tests.ilf.object_store import object_store

from .memory import resident

SETTINGS = BatchSettings(options=ExportOptions(depth_formats=("png",), cloud=None))
KEEP = ("depth", "expected_error", "blocks")
PER_SHARD = 1000


def main() -> None:
    """Measure all steps in turn."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000)
    count = parser.parse_args().count
    with tempfile.TemporaryDirectory() as place:
        root, out = Path(place) / "many", Path(place) / "shards"
        _write_frames(root, count)
        listed = partial(_listed, root)
        opened = partial(open_shards, listed, out, SETTINGS, KEEP, PER_SHARD, {})
        _step("listing", count, listed)
        _step("freezing, in this process", count, opened)
        batch = opened()
        _step(
            "reading the frozen list",
            count,
            lambda: sum(len(listed_frames(batch.folder, batch.shards, unit)) for unit in batch.units()),
        )
        _write_tables(batch, out)
        _step("resuming, all finished", count, lambda: list(complete_many(opened())))
        _resume_in_store(out, listed, count)
        _step("merging", count, lambda: merge_tables(folder_at(out)))
        _step("opening as a source", count, lambda: Shards(out).index())
        _step("opening as results", count, lambda: StoredResults(out))
        print(f"pickled results: {len(pickle.dumps(StoredResults(out))) / count:.0f} bytes a key")


def _step(what: str, count: int, work: Callable[[], object]) -> None:
    """Do some work; print its processor time for each key, and the memory before and after it."""
    before, start = resident(), sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    work()
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2]) - start
    print(f"{what}: {used / count * 1e6:.1f} us a key; memory {before:.0f}, then {resident():.0f} MB", flush=True)


def _write_frames(root: Path, count: int) -> None:
    for kind in ("rgb", "depth"):
        (root / kind).mkdir(parents=True)
        for number in range(count):
            (root / kind / f"{number:07}.png").touch()


def _read_list(batch: ShardSink) -> None:
    for index in batch.units():
        listed_frames(batch.folder, batch.shards, index)


def _listed(root: Path) -> list[BatchFrame]:
    return frames_of_sources([ilf.open_source(root)])


def _write_tables(batch: ShardSink, out: Path) -> None:
    """Write the tables of all shards, as if their frames had been completed."""
    for index in range(batch.shards.count):
        name, numbers = batch.shards.name(index), batch.shards.numbers(index)
        rows = [
            {"key": f"rgb/{n:07}", "status": "completed", "message": "", "offset": 0, "size": 0, "shard": f"{name}.tar"}
            | {key: os.urandom(32).hex() for key in ("rgb_sha256", "depth_sha256", "sha256")}
            for n in numbers
        ]
        facts = {"ilf": json.dumps({"sha256": batch.shards.sha256, "tar_sha256": "", "failed": 0})}
        table = pyarrow.Table.from_pylist(rows, schema().with_metadata(facts))
        pyarrow.parquet.write_table(table, out / f"{name}.parquet")


def _resume_in_store(out: Path, listed: Callable[[], list[BatchFrame]], count: int) -> None:
    with object_store() as settings:
        os.environ.update(settings)
        names = ["shards.json", "frames.jsonl", *(path.name for path in out.glob("shard-*.parquet"))]
        fsspec.filesystem("s3").put([str(out / name) for name in names], [f"bucket/out/{name}" for name in names])
        there = partial(open_shards, listed, "s3://bucket/out", SETTINGS, KEEP, PER_SHARD, {})
        _step("resuming in a store, with the store's own work", count, lambda: list(complete_many(there())))


if __name__ == "__main__":
    from tests.bench.shards import main  # a child process imports what it calls by the name of its module

    main()

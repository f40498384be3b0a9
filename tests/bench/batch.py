"""`python -m tests.bench.batch [kills] [dask] [rate] [memory] [--frames 164] [--data FOLDER]`: tests of batches.

kills    the process, then a worker is killed (-9) during the batch, then Ctrl+C; after another run, every frame exists
         exactly once, byte for byte as in an undisturbed batch
dask     the same with a worker of a Dask cluster, with the process that waits for it, and with a frame that kills
         every worker
rate     frames per second: one `ilf complete` after the other, and `ilf batch` with 1 and 2 jobs
memory   of the process and its worker over 2000 frames

Frames are generated; --data gives folders of real ones for the rate.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import ilf
from ilf.batch.batch import open_batch
from ilf.batch.frames import frames_of_sources, named_frames
from ilf.batch.settings import BatchSettings, write_settings
from tests.ilf.batch_frames import Deadly, contents, write_frames

ILF = [sys.executable, "-m", "ilf"]
SHAPE = 48, 64


def started(source: Path, out: Path, *flags: str) -> subprocess.Popen[str]:
    """Start a batch in its own process."""
    command = [*ILF, "batch", str(source), "--out", str(out), *flags]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen[str]) -> int:
    """Wait for the batch, print its output and return its exit status."""
    told, wrong = process.communicate()
    print(*(f"    {line}" for line in (told + wrong).splitlines()), sep="\n")
    return process.returncode


def finished(out: Path) -> int:
    """Return the number of finished frames."""
    return len(list(out.glob("*/frame.json")))


def when(process: subprocess.Popen[str], out: Path, count: int) -> None:
    """Wait until `count` frames are finished."""
    while finished(out) < count and process.poll() is None:
        time.sleep(0.01)


def children(process: int) -> list[int]:
    """Child processes that complete frames."""
    found = [child for path in Path(f"/proc/{process}/task").glob("*/children") for child in path.read_text().split()]
    return [int(child) for child in found if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]


def verdict(what: str, same: bool) -> bool:
    """Print whether a check has passed."""
    print(f"{'ok  ' if same else 'NOT '} {what}", flush=True)
    return same


def whole(out: Path) -> bool:
    """Return whether every folder holds a complete set and nothing else."""
    left = list(out.rglob(".ilf-*"))
    sets = [folder for folder in out.iterdir() if folder.is_dir() and not (folder / "frame.json").exists()]
    return not left and not sets


def kills(folder: Path, source: Path, undisturbed: Path, count: int) -> bool:
    """Kill the process, then a worker, then send Ctrl+C."""
    out = folder / "killed"
    process = started(source, out, "--jobs", "2")
    when(process, out, count // 4)
    process.kill()
    process.wait()
    time.sleep(1)  # its workers end with it
    good = [verdict(f"the process was killed after {finished(out)} finished frames", 0 < finished(out) < count)]
    process = started(source, out, "--jobs", "2")
    when(process, out, count // 2)
    os.kill(children(process.pid)[0], signal.SIGKILL)
    when(process, out, 3 * count // 4)
    process.send_signal(signal.SIGINT)
    good.append(verdict("a worker was killed, then Ctrl+C: exit status 130", ended(process) == 130))
    good.append(verdict(f"{finished(out)} frames finished, all of them complete", whole(out) and finished(out) < count))
    process = started(source, out, "--jobs", "2")
    good.append(verdict("run again: exit status 0", ended(process) == 0))
    good.append(verdict("the same as undisturbed, byte for byte", contents(out) == contents(undisturbed)))
    return all(good)


def dask(folder: Path, source: Path, undisturbed: Path, count: int) -> bool:
    """Kill a Dask worker and the waiting process, and run a frame that kills every worker."""
    import dask.config
    from distributed import LocalCluster

    # a local cluster gives up workers that restart slowly, as on a busy machine
    dask.config.set({"distributed.deploy.lost-worker-timeout": "10 minutes"})
    out = folder / "dask"
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=40) as cluster:
        address = cluster.scheduler_address
        process = started(source, out, "--dask", address)
        when(process, out, count // 4)
        os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
        when(process, out, count // 2)
        process.kill()
        process.wait()
        good = [verdict(f"a worker and the process were killed after {finished(out)} frames", finished(out) < count)]
        process = started(source, out, "--dask", address)
        good.append(verdict("run again: exit status 0", ended(process) == 0))
        good.append(verdict("the same as undisturbed, byte for byte", contents(out) == contents(undisturbed)))

        few = frames_of_sources([ilf.open_source(source)])[:8]
        frames = [*few, *named_frames([("deadly", Deadly("a.png", "b.png"), None)])]
        deadly = folder / "deadly"
        deadly.mkdir()
        settings = BatchSettings()
        write_settings(deadly, settings.facts(), (1.0, 3.0))
        outcomes = open_batch(frames, deadly, settings).outcomes(cluster=address)
        failed = [outcome.frame for outcome in outcomes if outcome.status == "failed"]
        good.append(verdict("of 9 frames, only the one that kills every worker failed", failed == ["deadly"]))
    return all(good)


def timed(what: str, count: int, work: Callable[[], object]) -> float:
    """Print frames per second of some work, with its computing time."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    work()
    took, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    computed = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"{what}: {count / took:.3f} frames per second, {computed / count:.2f} s of processor time each", flush=True)
    return count / took


def rate(folder: Path, sources: Sequence[Path]) -> bool:
    """Compare consecutive `ilf complete` commands with `ilf batch` with 1 and 2 jobs."""
    count = sum(len(ilf.open_source(source)) for source in sources)

    def one_by_one() -> None:
        for number, source in enumerate(sources):
            for key in ilf.open_source(source).keys:
                out = folder / "single" / f"{number}-{key.replace('/', '-')}"
                subprocess.run([*ILF, "complete", source, "--frame", key, "--out", out, "--quiet"], check=True)

    def batch(jobs: int) -> None:
        out = folder / f"jobs-{jobs}"
        subprocess.run([*ILF, "batch", *sources, "--out", out, "--jobs", str(jobs), "--quiet"], check=True)

    alone = timed("consecutive `ilf complete`", count, one_by_one)
    for jobs in (1, 2):
        print(f"  {timed(f'--jobs {jobs}', count, lambda jobs=jobs: batch(jobs)) / alone:.2f} times the rate")
    return verdict("1 and 2 jobs give the same bytes", contents(folder / "jobs-1") == contents(folder / "jobs-2"))


def memory(folder: Path, count: int = 2000) -> bool:
    """Print the memory [MB] of a process and its worker over many frames."""
    out, source = folder / "many", write_frames(folder / "many-in", count, (24, 32))
    process = started(source, out)
    sizes = []
    for step in range(1, 11):
        when(process, out, count * step // 10 - 2)
        if found := children(process.pid):
            sizes.append((resident(process.pid), resident(found[0])))
            print(f"    {finished(out)} frames: {sizes[-1][0]:.0f} and {sizes[-1][1]:.0f} MB", flush=True)
    good = ended(process) == 0
    (first, first_worker), (last, last_worker) = sizes[1], sizes[-1]
    flat = last < first + 20 and last_worker < first_worker + 20
    return verdict("memory stays within 20 MB of its value after a fifth of the frames", good and flat)


def resident(process: int) -> float:
    """Return the memory of a process in MB."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> int:
    """Run the requested tests."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", choices=("kills", "dask", "rate", "memory"), default=[])
    parser.add_argument("--frames", type=int, default=164)
    parser.add_argument("--data", type=Path, nargs="+")
    options = parser.parse_args()
    wanted = options.what or ["kills", "dask", "rate", "memory"]
    good = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if {"kills", "dask"} & set(wanted):
            source = write_frames(folder / "in", options.frames, SHAPE)
            undisturbed = folder / "undisturbed"
            good.append(verdict("undisturbed: exit status 0", ended(started(source, undisturbed)) == 0))
        if "kills" in wanted:
            good.append(kills(folder, source, undisturbed, options.frames))
        if "dask" in wanted:
            good.append(dask(folder, source, undisturbed, options.frames))
        if "rate" in wanted:
            good.append(rate(folder, options.data or [write_frames(folder / "rate", 16, (240, 320))]))
        if "memory" in wanted:
            good.append(memory(folder))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())

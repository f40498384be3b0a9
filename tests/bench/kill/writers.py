"""Test of all writers: they are killed with -9 at random moments, and the files in the folder are checked.

    python -m tests.bench.kill.writers [--kills 200] [--seed 0] [--only run project ...]

A child alternately writes two sets of files over each other; it is killed a random time after it has started one. After
the clean-up by the next writer, the folder must contain one of the two sets, complete, and nothing else: no truncated
file, no file of the other set, no temporary file, and no record that does not match. (The child is forked for speed, so
this does not run on Windows.)
"""

import argparse
import os
import random
import signal
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

from ilf.project.file import open_project
from ilf.run.record import read_record
from ilf.run.replaying import file_problems

from ..writers import WRITERS, Writer, contents, contents_after_cleanup

_LONGEST = 1.2
"""Maximum time of a kill, in multiples of the time to write a set."""


def kills_of(writer: Writer, folder: Path, kills: int, chance: random.Random) -> tuple[Counter[str], list[str]]:
    """Kill a writer `kills` times; return the sets that were found, and the errors."""
    write = writer.prepare(folder)
    target = folder / "out"
    sets = []
    for version in (0, 1):
        begun = time.monotonic()
        write(target, version)
        took = time.monotonic() - begun
        sets.append(contents(target))
    found: Counter[str] = Counter()
    wrong: list[str] = []
    for number in range(kills):
        _killed(write, target, first=number % 2, after=chance.uniform(0, _LONGEST * took))
        hidden = any(Path(name).parts[0].startswith(".ilf-") for name in contents(target))
        left = contents_after_cleanup(target)
        whole = [
            version
            for version, files in enumerate(sets)
            if left.keys() == files.keys() and all(left[name] == files[name] for name in writer.steady(files))
        ]
        problem = "" if not writer.varying else _problem(target, left)
        if problem or not whole:
            wrong.append(f"{writer.name}, kill {number}: {problem or f'no complete set: {sorted(left)}'}")
        else:
            found["in the middle" if hidden else "between"] += 1
    return found, wrong


def _killed(write: object, target: Path, first: int, after: float) -> None:
    """Write alternately in another process, and kill it after `seconds`."""
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child needs no other thread
        child = os.fork()
    if child == 0:
        try:
            os.write(writing, b".")
            for version in range(first, 10**9):
                write(target, version % 2)  # type: ignore[operator]
        finally:
            os._exit(1)
    os.read(reading, 1)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(reading)
    os.close(writing)
    if os.WIFEXITED(status):
        raise RuntimeError(f"the writer ended unexpectedly, with status {status}")


def _problem(target: Path, left: dict[str, bytes]) -> str:
    """Check the files that differ at each writing with their reader; return the error."""
    if "run.json" in left:
        return " ".join(file_problems(read_record(target / "run.json"), target))
    with open_project(target / "work.ilf") as opened:
        return " ".join(opened.problems)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200, help="number of kills of all writers together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", choices=list(WRITERS), default=list(WRITERS))
    given = parser.parse_args()
    chance = random.Random(given.seed)
    failed = False
    for name in given.only:
        with tempfile.TemporaryDirectory() as folder:
            found, wrong = kills_of(WRITERS[name], Path(folder).resolve(), given.kills // len(given.only), chance)
        counts = ", ".join(f"{count} {where}" for where, count in sorted(found.items()))
        print(f"{name:10} complete after kills: {counts}; {len(wrong)} wrong", *wrong[:5], sep="\n    ", flush=True)
        failed |= bool(wrong)
    raise SystemExit(failed)


if __name__ == "__main__":
    main()

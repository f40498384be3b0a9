"""Whoever writes files is killed with -9 at random moments, and what lies in the folder is looked at.

    python -m tests.bench.kill.writers [--kills 200] [--seed 0] [--only run project ...]

A child writes two sets of files by turns, over each other; it is killed a random time after it has begun with one.
After what the next writer does first, the folder must hold one of the two sets, whole, and nothing else: no file cut
short, none of the other set, no temporary file, and no record that does not fit. (A child is forked, for speed: not
on Windows.)
"""

from __future__ import annotations

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
from ilf.run.record_file import read_record
from ilf.run.replaying import missing_or_changed

from ..writers import WRITERS, Writer, as_found, contents

_LONGEST = 1.2
"""A kill comes after at most so many times what writing a set takes."""


def kills_of(writer: Writer, folder: Path, kills: int, chance: random.Random) -> tuple[Counter[str], list[str]]:
    """Kill a writer so many times; what was found, and what was wrong with it."""
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
        left = as_found(target)
        whole = [
            version
            for version, files in enumerate(sets)
            if left.keys() == files.keys() and all(left[name] == files[name] for name in writer.steady(files))
        ]
        problem = "" if not writer.varying else _problem(target, left)
        if problem or not whole:
            wrong.append(f"{writer.name}, kill {number}: {problem or f'no whole set: {sorted(left)}'}")
        else:
            found["in the middle" if hidden else "between"] += 1
    return found, wrong


def _killed(write: object, target: Path, first: int, after: float) -> None:
    """Write by turns in another process, and kill it after so many seconds."""
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # other threads do nothing that the child needs
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
        raise RuntimeError(f"the writer has ended by itself, with {status}")


def _problem(target: Path, left: dict[str, bytes]) -> str:
    """What a reader would say of the files that are other ones each time."""
    if "run.json" in left:
        return " ".join(missing_or_changed(read_record(target / "run.json"), target))
    with open_project(target / "work.ilf") as opened:
        return " ".join(opened.problems)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200, help="of all writers together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", choices=list(WRITERS), default=list(WRITERS))
    given = parser.parse_args()
    chance = random.Random(given.seed)
    failed = False
    for name in given.only:
        with tempfile.TemporaryDirectory() as folder:
            found, wrong = kills_of(WRITERS[name], Path(folder).resolve(), given.kills // len(given.only), chance)
        counts = ", ".join(f"{count} {where}" for where, count in sorted(found.items()))
        print(f"{name:10} whole after kills: {counts}; {len(wrong)} wrong", *wrong[:5], sep="\n    ", flush=True)
        failed |= bool(wrong)
    raise SystemExit(failed)


if __name__ == "__main__":
    main()

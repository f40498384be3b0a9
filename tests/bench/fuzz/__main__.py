"""Read thousands of damaged files of every format, and count the results.

    python -m tests.bench.fuzz [--cases 10000] [--format NAME ...] [--seed 0] [--first 0] [--jobs 1] [--keep FOLDER]
    python -m tests.bench.fuzz --sound

Each file is read as the program reads it, by a child process. The file is read (ok) or refused with an error of one
line (told); anything else is a fault: a traceback or a warning of a library, a crash, more than 10 s (hang), or
more than 1 GB of memory. Case N of a seed is the same file every time; --keep stores the files that caused faults.
"""

import argparse
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .formats import FORMATS
from .pool import Tally, read_cases
from .worker import sound_files

_COLUMNS = ("cases", "ok", "told", "traceback", "crash", "hang", "memory", "slowest [s]", "peak [MB]")


def main() -> int:
    """Run the fuzz test; exit status 1 if any file gave a result other than "ok" and "told"."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=10_000, help="cases per format (default: 10000)")
    parser.add_argument("--sound", action="store_true", help="only read the valid files, all in this process")
    parser.add_argument("--format", nargs="+", choices=FORMATS, default=list(FORMATS), metavar="NAME")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first case, to repeat a single one")
    parser.add_argument("--jobs", type=int, default=1, help="formats read in parallel")
    parser.add_argument("--keep", type=Path, help="folder for files that caused a fault")
    parser.add_argument("--told", type=int, default=0, metavar="N", help="print the N most frequent messages")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    if options.sound:
        return _read_sound_files(options.format)
    last = options.first + options.cases
    print("| format | " + " | ".join(_COLUMNS) + " |\n|---|" + "---|" * len(_COLUMNS), flush=True)

    def one(name: str) -> Tally:
        tally = read_cases(name, options.seed, options.first, last, options.keep)
        print(_row(name, options.cases, tally), flush=True)
        return tally

    with ThreadPoolExecutor(options.jobs) as pool:
        tallies = dict(zip(options.format, pool.map(one, options.format), strict=True))
    for name, tally in tallies.items():
        faults = Counter((kind, what) for _, kind, what in tally.bad)
        numbers = {(kind, what): number for number, kind, what in reversed(tally.bad)}
        for (kind, what), count in faults.most_common():
            print(f"{name}: {count} x {kind}: {what} (case {numbers[kind, what]})")
        for what, count in tally.told.most_common(options.told):
            print(f"{name}: {count} x told: {what}")
    return int(any(tally.bad for tally in tallies.values()))


def _read_sound_files(names: list[str]) -> int:
    for name in names:
        with tempfile.TemporaryDirectory(prefix="ilf-fuzz-") as place:
            seeds = sound_files(FORMATS[name], Path(place))
        print(f"{name}: {len(seeds)} valid files are read")
    return 0


def _row(name: str, cases: int, tally: Tally) -> str:
    counts = [tally.kinds[kind] for kind in _COLUMNS[1:7]]
    return f"| {name} | {cases} | {' | '.join(map(str, counts))} | {tally.slowest:.2f} | {tally.peak / 1e6:.0f} |"


if __name__ == "__main__":
    raise SystemExit(main())

"""Compare what two states of the code make, bit for bit, on one machine.

    python -m tests.pins COMMIT                   # a commit and the working tree
    python -m tests.pins --write before.json      # write the table of the working tree ...
    python -m tests.pins before.json              # ... and compare with it later

The table has a SHA-256 of everything that is made with some settings by the library and the command line (`library`),
and in sessions of the window (`window`). What is done for it is the working tree's `tests/pins`, also for a commit.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from .hashes import Hashes

PINS = Path(__file__).parent
ROOT = PINS.parents[1]

HALVES = {"library": "library.py", "window": "window/table.py"}
"""Half of the table -> the module whose `make` makes it."""

Table = dict[str, dict[str, Hashes]]
"""Half -> setting or session -> what -> SHA-256."""


def main(argv: Sequence[str] | None = None) -> int:
    """Write or compare tables. Returns the exit status: 1 where a hash differs."""
    parser = argparse.ArgumentParser("python -m tests.pins", description="Compare results bit for bit.")
    either = parser.add_mutually_exclusive_group(required=True)
    either.add_argument("before", nargs="?", metavar="COMMIT|FILE", help="compare with a commit, or a written table")
    either.add_argument("--write", type=Path, metavar="FILE", help="write the table of the working tree")
    parser.add_argument("--only", choices=HALVES, help="only this half of the table")
    arguments = parser.parse_args(argv)
    halves = [arguments.only] if arguments.only else [half for half, file in HALVES.items() if (PINS / file).is_file()]
    if arguments.write:
        arguments.write.write_text(json.dumps(make(halves), indent=1))
        return 0
    if Path(arguments.before).is_file():
        written = json.loads(Path(arguments.before).read_text())
        before = {half: written[half] for half in halves if half in written}
        if not before:
            parser.error(f"{arguments.before} has none of these halves: {', '.join(halves)}. Write it anew.")
    elif _git("rev-parse", "--verify", "--quiet", f"{arguments.before}^{{commit}}").returncode:
        parser.error(f"{arguments.before} is neither a commit nor a table.")
    else:
        before = make_of_commit(arguments.before, halves)
    return compare(before, make(list(before)))


def make(halves: Sequence[str]) -> Table:
    """Make the table of the code that this process imports."""
    modules = {half: HALVES[half].removesuffix(".py").replace("/", ".") for half in halves}
    return {half: import_module(f".{module}", __package__).make() for half, module in modules.items()}


def make_of_commit(commit: str, halves: Sequence[str]) -> Table:
    """Make the table of a commit, in a process of its own for each half."""
    table = {}
    with TemporaryDirectory() as temporary, worktree(commit, Path(temporary).resolve() / "tree") as tree:
        shutil.rmtree(tree / "tests" / "pins", ignore_errors=True)
        shutil.copytree(PINS, tree / "tests" / "pins")
        packages = {"PYTHONPATH": os.pathsep.join([str(tree), str(tree / ".ci" / "editable")])}
        # of compiled loops: it has entries for the path of their source, which never comes again
        cache = {"NUMBA_CACHE_DIR": f"{temporary}/numba"}
        for half in halves:
            file = Path(temporary, f"{half}.json")
            command = [sys.executable, "-m", "tests.pins", "--write", str(file), "--only", half]
            subprocess.run(command, cwd=tree, env=os.environ | packages | cache, check=True)
            table |= json.loads(file.read_text())
    return table


@contextmanager
def worktree(commit: str, folder: Path) -> Iterator[Path]:
    """A commit's files, checked out beside the repository while this lasts."""
    try:
        _git("worktree", "add", "--detach", str(folder), commit, check=True)
        yield folder
    finally:
        _git("worktree", "remove", "--force", str(folder))


def _git(*words: str, check: bool = False) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", "-C", str(ROOT), *words], check=check, capture_output=True, text=True)


def compare(before: Table, now: Table) -> int:
    """Print every difference, and the number of equal hashes; returns 1 if any differs, else 0."""
    then, today = _lines(before), _lines(now)
    differences = [line for line in then | today if then.get(line) != today.get(line)]
    for line in differences:
        print(line, "differs" if line in then and line in today else "is gone" if line in then else "is new")
    print(f"{len(then | today) - len(differences)} of {len(then | today)} hashes equal")
    return int(bool(differences))


def _lines(table: Table) -> Hashes:
    """The table in one level."""
    return {
        f"{half}, {name}, {what}": sha256
        for half, made in table.items()
        for name, hashes in made.items()
        for what, sha256 in hashes.items()
    }


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # a worktree is removed then, too
    sys.exit(main())

"""Compare what two states of the code make, bit for bit, on one machine.

    python -m tests.pins COMMIT                   # a commit and the working tree
    python -m tests.pins --write before.json      # write the table of the working tree ...
    python -m tests.pins before.json              # ... and compare with it later

The table has a SHA-256 of everything that is made with some settings by the library and the command line (`library`),
and in sessions of the window (`window`). With a commit, pictures of the window are compared as well (`pictures`), which
may differ by what nobody sees. What is done is the working tree's `tests/pins`, also for a commit.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from .hashes import Hashes

PINS = Path(__file__).parent
ROOT = PINS.parents[1]

HALVES = {"library": "library.py", "window": "window/table.py"}
"""Half of the table -> the module whose `make` makes it."""

PICTURES = "pictures"

Table = dict[str, dict[str, Hashes]]
"""Half -> setting or session -> what -> SHA-256."""


def main(argv: Sequence[str] | None = None) -> int:
    """Write or compare tables. Returns the exit status: 1 where a hash differs."""
    parser = argparse.ArgumentParser("python -m tests.pins", description="Compare results bit for bit.")
    either = parser.add_mutually_exclusive_group(required=True)
    either.add_argument("before", nargs="?", metavar="COMMIT|FILE", help="compare with a commit, or a written table")
    either.add_argument("--write", type=Path, metavar="FILE", help="write the table of the working tree")
    parser.add_argument("--only", choices=[*HALVES, PICTURES], help="only this part")
    arguments = parser.parse_args(argv)
    halves = [arguments.only] if arguments.only in HALVES else [] if arguments.only else list(HALVES)
    if arguments.only == PICTURES and (arguments.write or Path(arguments.before).is_file()):
        parser.error("Pictures are compared with those of a commit.")
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
        status = 0 if arguments.only in HALVES else compare_pictures(arguments.before)
        before = make_of_commit(arguments.before, halves)
        return compare(before, make(halves)) or status if halves else status
    return compare(before, make(list(before)))


def make(halves: Sequence[str]) -> Table:
    """Make the table of the code that this process imports."""
    modules = {half: HALVES[half].removesuffix(".py").replace("/", ".") for half in halves}
    return {half: import_module(f".{module}", __package__).make() for half, module in modules.items()}


def make_of_commit(commit: str, halves: Sequence[str]) -> Table:
    """Make the table of a commit, in a process of its own for each half."""
    table: Table = {}
    with TemporaryDirectory() as temporary, program_of(commit, Path(temporary).resolve()) as run:
        for half in halves:
            file = Path(temporary, f"{half}.json")
            run("tests.pins", "--write", str(file), "--only", half)
            table |= json.loads(file.read_text())
    return table


def compare_pictures(commit: str) -> int:
    """Print what differs between the window's pictures of a commit and of the working tree; returns 1 if any does."""
    with TemporaryDirectory() as temporary, program_of(commit, Path(temporary).resolve()) as run:
        before, now = Path(temporary, "before"), Path(temporary, "now")
        run("tests.pins.window.pictures", str(before))
        subprocess.run([sys.executable, "-m", "tests.pins.window.pictures", str(now)], cwd=ROOT, check=True)
        found = import_module(".window.pictures", __package__).differences(before, now)
        print(*found, f"{len(list(now.iterdir()))} pictures, {len(found)} differ", sep="\n")
    return int(bool(found))


@contextmanager
def program_of(commit: str, temporary: Path) -> Iterator[Callable[..., object]]:
    """A function that runs a module with arguments, with the program of a commit and the present pins."""
    with worktree(commit, temporary / "tree") as tree:
        shutil.rmtree(tree / "tests" / "pins", ignore_errors=True)
        shutil.copytree(PINS, tree / "tests" / "pins")
        packages = {"PYTHONPATH": os.pathsep.join([str(tree), str(tree / ".ci" / "editable")])}
        # of compiled loops: it has entries for the path of their source, which never comes again
        environment = os.environ | packages | {"NUMBA_CACHE_DIR": str(temporary / "numba")}
        yield lambda *words: subprocess.run([sys.executable, "-m", *words], cwd=tree, env=environment, check=True)


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

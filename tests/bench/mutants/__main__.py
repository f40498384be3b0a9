"""`python -m tests.bench.mutants --sample 150 --seed 0`: how many deliberate faults the tests find.

First the suites run once, to record which tests run which lines; that is kept until a file changes. Then every fault of
the sample is made in the functions of a process, and the tests that run its lines are run until one fails, fast ones
first, up to the time `--longest`. Faults are in functions alone. Leave the files alone meanwhile. (The processes are
forked, so this does not run on Windows.)
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .covering import PACKAGES
from .sites import Mutant, sample

ROOT = Path(__file__).resolve().parents[3]
SUITES = ("tests/ilf", "tests/gui", "tests/e2e")

_ENVIRONMENT = {
    "PYTHONPATH": str(ROOT),
    "PYTHONHASHSEED": "0",
    "QT_QPA_PLATFORM": "offscreen",
    "CI": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "COVERAGE_CORE": "ctrace",
}
"""Of tests without a display that give the same each time."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the sample, and print the survivors and the score."""
    options = _parser().parse_args(arguments)
    options.out = options.out.absolute()
    options.out.mkdir(parents=True, exist_ok=True)
    mutants = sample(ROOT, _python_files(options.only), options.sample, options.seed)
    with ThreadPoolExecutor(options.jobs) as pool:
        parts = list(pool.map(lambda suite: _covering(suite, options.out), options.suites))
        seconds = {test: took for part in parts for test, took in part["seconds"].items()}
        tests = [_tests_of(mutant, parts) for mutant in mutants]
        shares = [range(start, len(mutants), options.jobs) for start in range(min(options.jobs, len(mutants)))]
        given = {"suites": options.suites, "seconds": seconds, "longest": options.longest}
        asked = [
            given | {"mutants": [asdict(mutants[at]) for at in share], "tests": [tests[at] for at in share]}
            for share in shares
        ]
        found = pool.map(
            lambda number: _try_all(asked[number], options.out / f"faults-{number}.json"), range(len(asked))
        )
        outcomes = {
            share[trial["number"]]: trial for share, trials in zip(shares, found, strict=True) for trial in trials
        }
    _report(mutants, outcomes)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.mutants", description="Deliberate faults for the tests."
    )
    parser.add_argument("--sample", type=int, default=150, metavar="N", help="number of faults (default: 150)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample (default: 0)")
    parser.add_argument(
        "--only", nargs="+", metavar="PATH", default=PACKAGES, help="files or folders (default: the whole program)"
    )
    parser.add_argument("--suites", nargs="+", default=SUITES, metavar="PATH", help="tests (default: all suites)")
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count() or 1, help="faults in parallel (default: one per core)"
    )
    parser.add_argument(
        "--longest", type=float, default=300.0, metavar="S", help="limit of the usual duration of a fault's tests"
    )
    parser.add_argument(
        "--out", type=Path, default=ROOT / "build/mutants", help="folder for what is known of the tests"
    )
    return parser


def _python_files(targets: Sequence[str]) -> list[str]:
    """The Python files among files and folders, without those that run when they are imported."""
    paths = [
        path
        for target in targets
        for path in ([ROOT / target] if target.endswith(".py") else (ROOT / target).rglob("*.py"))
    ]
    return sorted(path.relative_to(ROOT).as_posix() for path in paths if path.name != "__main__.py")


def _run(module: str, *words: str) -> Iterator[str]:
    """The lines that a module of this package prints, in a process without a display."""
    environment = os.environ | _ENVIRONMENT
    command = [sys.executable, "-m", f"{__package__}.{module}", *words]
    said = deque[str](maxlen=40)
    with subprocess.Popen(command, cwd=ROOT, env=environment, text=True, stdout=subprocess.PIPE) as process:
        for line in process.stdout or ():
            said.append(line)
            yield line
    if process.returncode:
        raise RuntimeError(f"`{' '.join(command)}` ended with status {process.returncode}:\n{''.join(said)}")


def _covering(suite: str, folder: Path) -> dict[str, Any]:
    """Which tests of a suite run which lines."""
    digest = hashlib.sha256(suite.encode())
    for path in sorted(path for part in (*PACKAGES, "tests") for path in (ROOT / part).rglob("*.py")):
        digest.update(path.read_bytes())
    kept = folder / f"{digest.hexdigest()[:16]}.json"
    if not kept.is_file():
        print(f"running {suite} for its coverage", flush=True)
        list(_run("covering", str(kept), suite))
    found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
    for test in found["failed"]:
        print(f"left out, because it fails without a fault: {test}", flush=True)
    return found


def _tests_of(mutant: Mutant, parts: Sequence[dict[str, Any]]) -> list[str]:
    """The tests that run a line of the statement; coverage does not list all lines of one over several lines."""
    lines = [part["lines"].get(mutant.path, {}) for part in parts]
    numbers = range(mutant.first, mutant.last + 1)
    return sorted({test for known in lines for number in numbers for test in known.get(str(number), [])})


def _try_all(asked: dict[str, Any], file: Path) -> list[dict[str, Any]]:
    """The outcomes of some faults, which are printed as they come."""
    file.write_text(json.dumps(asked), encoding="utf-8")
    found = []
    for line in _run("trials", str(file)):
        trial = json.loads(line)
        mutant = asked["mutants"][trial["number"]]
        print(
            f"{trial['outcome']:8} {trial['tests']:4} tests: {mutant['path']}:{mutant['first']} {trial['killer']}",
            flush=True,
        )
        found.append(trial)
    return found


def _report(mutants: Sequence[Mutant], outcomes: dict[int, dict[str, Any]]) -> None:
    by_file: dict[str, Counter[str]] = {}
    for at, mutant in enumerate(mutants):
        trial = outcomes[at]
        by_file.setdefault(mutant.path, Counter())[trial["outcome"]] += 1
        if trial["outcome"] == "survived":
            why = f"{trial['tests']} tests of it tried" if trial["tests"] else "no test runs it"
            print(f"\nsurvived ({why}): {mutant.diff((ROOT / mutant.path).read_text(encoding='utf-8'))}")
    print()
    for path, counts in sorted(by_file.items()):
        print(f"{counts.total() - counts['survived']:4} of {counts.total():3} found  {path}")
    total = sum(by_file.values(), Counter[str]())
    score = 1 - total["survived"] / max(total.total(), 1)
    counted = ", ".join(f"{total[name]} {name}" for name in ("killed", "timeout", "survived"))
    print(f"\n{counted}: {score:.1%} of {total.total()} faults found")


if __name__ == "__main__":
    sys.exit(main())

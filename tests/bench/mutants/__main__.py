"""`python -m tests.bench.mutants --sample 150 --seed 0`: how many deliberate faults the tests find.

Needs `pip install -e '.[dev]'`. First every test file runs once, to record which tests run which lines. Then every
fault of the sample is made in a copy of the tree, and the tests that run its line are run until one fails, fast ones
first, up to the time `--longest`. Coverage and results are stored: the same command resumes after an interruption, and
after new tests it tries only the surviving faults again. `--fresh` deletes the stored results.
"""

import argparse
import json
import os
import queue
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .covering import SUITES, collect
from .sites import Mutant, sample
from .trees import PACKAGES, copy_tree, file_hash, python_files, take_tree, tree_hash
from .trials import Trial, Trials

ROOT = Path(__file__).resolve().parents[3]


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the sample, and print the survivors and the score."""
    options = _parser().parse_args(arguments)
    options.out = options.out.absolute()
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="ilf-mutants-") as folder:
        tree = take_tree(ROOT, Path(folder) / "tree")
        results = Results(options.out / "results.json", tree, options.fresh)
        mutants = sample(tree, python_files(tree, options.only), options.sample, options.seed)
        to_try = [mutant for mutant in mutants if not results.holds(mutant)]
        print(f"{len(mutants)} faults, {len(mutants) - len(to_try)} of them tried before", flush=True)
        if to_try:
            print("running the tests whose coverage is unknown", flush=True)
            paths = sorted({mutant.path for mutant in to_try})
            clean = copy_tree(tree, tree.with_name("covering"))
            covering = collect(clean, paths, options.suites, options.jobs, options.out / "covering")
            _try_all(tree, to_try, Trials(tree, covering, options.longest), results, options.jobs)
        _report(tree, mutants, results)
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
    parser.add_argument("--out", type=Path, default=ROOT / "build/mutants", help="folder for results")
    parser.add_argument("--fresh", action="store_true", help="delete stored results")
    return parser


class Results:
    """Results of tried faults, in a file that is written after every fault."""

    def __init__(self, path: Path, tree: Path, fresh: bool) -> None:
        self._path = path
        self._tree = tree
        self._hash = tree_hash(tree)
        self._entries: dict[str, dict[str, Any]] = {}
        if path.is_file() and not fresh:
            self._entries = json.loads(path.read_text(encoding="utf-8"))

    def holds(self, mutant: Mutant) -> bool:
        """Return whether the fault need not be tried: it was found in the same file, or survived in the same tree."""
        entry = self.entry(mutant)
        if entry is None or entry["file"] != file_hash(self._tree, mutant.path):
            return False
        return entry["outcome"] != "survived" or entry["tree"] == self._hash

    def entry(self, mutant: Mutant) -> dict[str, Any] | None:
        """Return the stored result of a fault."""
        return self._entries.get(_key(mutant))

    def add(self, mutant: Mutant, trial: Trial) -> None:
        """Store the result of a fault."""
        known = {"file": file_hash(self._tree, mutant.path), "tree": self._hash}
        self._entries[_key(mutant)] = asdict(mutant) | asdict(trial) | known
        temporary = self._path.with_suffix(".part")
        temporary.write_text(json.dumps(self._entries, indent=1), encoding="utf-8")
        temporary.replace(self._path)


def _key(mutant: Mutant) -> str:
    return f"{mutant.path}:{mutant.operator}:{mutant.occurrence}"


def _try_all(tree: Path, mutants: list[Mutant], trials: Trials, results: Results, jobs: int) -> None:
    trees: queue.SimpleQueue[Path] = queue.SimpleQueue()
    for number in range(jobs):
        trees.put(copy_tree(tree, tree.with_name(f"tree-{number}")))

    def attempt(mutant: Mutant) -> tuple[Trial, float]:
        copy, started = trees.get(), time.monotonic()
        try:
            return trials.run(mutant, copy), time.monotonic() - started
        finally:
            trees.put(copy)

    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(attempt, mutant): mutant for mutant in mutants}
        try:
            for number, done in enumerate(as_completed(waiting), 1):
                mutant, (trial, seconds) = waiting[done], done.result()
                results.add(mutant, trial)
                place = f"{mutant.path}:{mutant.line}"
                print(
                    f"{number}/{len(mutants)} {trial.outcome:8} {seconds:5.0f} s, {trial.tests} tests: {place} "
                    f"{mutant.operator.removeprefix('core/')} {trial.killer}",
                    flush=True,
                )
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _report(tree: Path, mutants: list[Mutant], results: Results) -> None:
    counts = dict.fromkeys(("killed", "timeout", "survived"), 0)
    by_file: dict[str, list[int]] = {}
    for mutant in mutants:
        entry = results.entry(mutant)
        if entry is None:
            continue
        counts[entry["outcome"]] += 1
        found, tried = by_file.setdefault(mutant.path, [0, 0])
        by_file[mutant.path] = [found + (entry["outcome"] != "survived"), tried + 1]
        if entry["outcome"] == "survived":
            why = f"{entry['tests']} tests of it tried" if entry["tests"] else "no test runs it"
            print(f"\nsurvived ({why}), {mutant.operator.removeprefix('core/')}:")
            print(mutant.diff((tree / mutant.path).read_text(encoding="utf-8")))
    print()
    for path, (found, tried) in sorted(by_file.items()):
        print(f"{found:4} of {tried:3} found  {path}")
    total = sum(counts.values())
    score = (total - counts["survived"]) / total if total else 0.0
    print(f"\n{', '.join(f'{count} {name}' for name, count in counts.items())}: {score:.1%} of {total} faults found")


if __name__ == "__main__":
    sys.exit(main())

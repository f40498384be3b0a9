"""How many of the first suspicious places are faults that were made on purpose.

python -m tests.bench.suspects [--choose] [--seed 0]

Ten faults in each of ten frames whose depth is known everywhere: blocks are extracted from all of it and spoilt, holes
are cut into it, and places are looked for in what is left. A place is real if it is the first one about a fault. Of the
others, "there before" are those at which true depth jumps inside a block: faults of the extraction, not made here.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from ilf import load_frame

from .spoiling import KINDS
from .trials import Trial, try_frame

CHOSEN_ON = ("0035", "0057", "0119", "0153", "0172", "0211", "0273", "0334", "0390", "0462")
"""Frames on which the weights of `ilf.suspicion` were chosen."""

REPORTED_ON = ("0040", "0059", "0091", "0169", "0176", "0283", "0352", "0411", "0476", "0519")
"""Others, on which they are reported."""

FAULTS, TOP = 10, 20


def first_of_all(trials: Sequence[Trial]) -> Counter[str]:
    """What the places with the highest scores of all frames are: real, again about one of those, before, nothing."""
    findings = [(finding, trial.name) for trial in trials for finding in trial.found]
    findings.sort(key=lambda one: -one[0].place.score)
    seen: set[tuple[str, int]] = set()
    kinds: Counter[str] = Counter()
    for finding, name in findings[:TOP]:
        if finding.fault is None:
            kinds["before" if finding.before else "nothing"] += 1
            continue
        kinds["again" if (name, finding.fault) in seen else "real"] += 1
        seen.add((name, finding.fault))
    return kinds


def by_kind(trials: Sequence[Trial]) -> Iterable[tuple[object, ...]]:
    """Of every kind of fault, how many there are and how many are found among the first places of their frames."""
    for kind in (*KINDS, "all"):
        row: list[object] = [kind]
        for top in (None, FAULTS, TOP, 10_000):
            numbers = ((trial, range(len(trial.faults)) if top is None else trial.hits(top)) for trial in trials)
            row.append(sum(kind in ("all", trial.faults[number].kind) for trial, which in numbers for number in which))
        yield tuple(row)


def by_frame(trials: Sequence[Trial]) -> Iterable[tuple[object, ...]]:
    """Of every frame, how many faults are found, and how many places there are."""
    for trial in trials:
        before = sum(finding.before for finding in trial.found[:TOP])
        yield trial.name, len(trial.faults), len(trial.hits(FAULTS)), len(trial.hits(TOP)), before, len(trial.found)


def by_place(trials: Sequence[Trial]) -> Iterable[tuple[object, ...]]:
    """Of every kind of place among the first of the frames, how many there are and what they are about."""
    first = [finding for trial in trials for finding in trial.found[:TOP]]
    for kind in sorted({finding.place.kind for finding in first}):
        of_kind = [finding for finding in first if finding.place.kind == kind]
        about = sum(finding.fault is not None for finding in of_kind)
        yield kind, len(of_kind), about, sum(finding.before for finding in of_kind)


def table(head: str, rows: Iterable[tuple[object, ...]]) -> str:
    """As Markdown."""
    columns = head.split(" | ")
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--choose", action="store_true", help="on the frames that weights were chosen on")
    arguments = parser.parse_args()
    root = Path(os.environ.get("ILF_TEST_DATA", "../shared/data")) / "rgbd"
    trials = []
    for name in CHOSEN_ON if arguments.choose else REPORTED_ON:
        folder = root / f"nyufilled_{name}"
        truth = load_frame(folder / "rgb.jpg", folder / "gt.png", depth_units=1000, name=folder.name)
        trials.append(try_frame(truth, FAULTS, arguments.seed))
    first = first_of_all(trials)
    print(
        f"{sum(len(trial.faults) for trial in trials)} faults in {len(trials)} frames. Of the {TOP} places with the "
        f"highest scores of all, {first['real']} are real, {first['again']} are about one of those again, "
        f"{first['before']} were there before, {first['nothing']} are nothing.\n"
    )
    print(table(f"fault | made | in the first {FAULTS} of its frame | in the first {TOP} | at all", by_kind(trials)))
    head = f"frame | made | real of the first {FAULTS} | of the first {TOP} | there before, of the first {TOP} | places"
    print(table(head, by_frame(trials)))
    print(table(f"place | in the first {TOP} of the frames | about a fault | there before", by_place(trials)))


if __name__ == "__main__":
    main()

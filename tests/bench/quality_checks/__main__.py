"""Precision of the quality checks: how many of the first flagged places are deliberate faults.

python -m tests.bench.quality_checks [FRAME ...] [--seed 0]

Ten faults in each frame, whose ground truth has no missing depth: blocks are extracted from the full depth and get
faults, holes are cut into the depth, and the quality checks run on the rest. A flagged place is real if it is the first
one at a fault. Of the others, "there before" are those at which true depth jumps inside a block: errors of the
extraction.

The remedy for the first place at each fault is applied. It mends the fault if it halves what the blocks' IoU with those
without the fault lacks; "worse" is a lower IoU.
"""

import argparse
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from ilf import load_frame

from .faults import KINDS
from .trials import Mending, Trial, try_frame

FAULTS, TOP = 10, 20
_EVALUATION = ("0040", "0059", "0091", "0169", "0176", "0283", "0352", "0411", "0476", "0519")
"""Filled frames of NYU on which the weights of the quality checks were not tuned."""


def _evaluation_frames() -> list[Path]:
    root = Path(os.environ.get("ILF_TEST_DATA", "../shared/data")) / "rgbd"
    return [root / f"nyufilled_{name}" for name in _EVALUATION]


def first_of_all(trials: Sequence[Trial]) -> Counter[str]:
    """Classify the places with the highest scores of all frames: real, repeated, there before, or no fault."""
    findings = [(finding, trial.name) for trial in trials for finding in trial.found]
    findings.sort(key=lambda one: -one[0].place.score)
    caption: set[tuple[str, int]] = set()
    kinds: Counter[str] = Counter()
    for finding, name in findings[:TOP]:
        if finding.fault is None:
            kinds["before" if finding.before else "nothing"] += 1
            continue
        kinds["again" if (name, finding.fault) in caption else "real"] += 1
        caption.add((name, finding.fault))
    return kinds


def by_kind(trials: Sequence[Trial]) -> Iterable[tuple[object, ...]]:
    """Table of the kinds of fault: their number, and how many are among the first places of their frames."""
    for kind in (*KINDS, "all"):
        row: list[object] = [kind]
        for top in (None, FAULTS, TOP, 10_000):
            numbers = ((trial, range(len(trial.faults)) if top is None else trial.hits(top)) for trial in trials)
            row.append(sum(kind in ("all", trial.faults[number].kind) for trial, which in numbers for number in which))
        yield tuple(row)


def by_remedy(trials: Sequence[Trial]) -> Iterable[tuple[object, ...]]:
    """Table of the kinds of fault, and of remedy: how many are found, have a remedy, are mended by it and made worse,
    and the mean IoU of the blocks before and after it."""
    found = [(trial.faults[number].kind, one) for trial in trials for number, one in trial.mended.items()]
    for kind in (*KINDS, "all"):
        yield kind, *_mending_row([one for fault, one in found if kind in ("all", fault)])
    for kind in sorted({one.remedy for _, one in found} - {""}):
        yield f"by {kind}", *_mending_row([one for _, one in found if one.remedy == kind])


def _mending_row(found: Sequence[Mending]) -> tuple[object, ...]:
    tried = [one for one in found if one.remedy]
    before, after = (sum(getattr(one, name) for one in found) / max(len(found), 1) for name in ("before", "after"))
    worse = sum(one.after < one.before for one in tried)
    return len(found), len(tried), sum(one.mends for one in tried), worse, f"{before:.3f}", f"{after:.3f}"


def table(head: str, rows: Iterable[tuple[object, ...]]) -> str:
    """Format a table as Markdown."""
    columns = head.split(" | ")
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("frames", nargs="*", type=Path, default=_evaluation_frames())
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    trials = []
    for folder in arguments.frames:
        ground_truth = load_frame(next(folder.glob("rgb.*")), folder / "gt.png", depth_units=1000, name=folder.name)
        trials.append(try_frame(ground_truth, FAULTS, arguments.seed))
    first = first_of_all(trials)
    print(
        f"{sum(len(trial.faults) for trial in trials)} faults in {len(trials)} frames. Of the {TOP} places with the "
        f"highest scores of all, {first['real']} are real, {first['again']} repeat one of these, "
        f"{first['before']} were there before, {first['nothing']} are no fault.\n"
    )
    print(table(f"fault | made | in the first {FAULTS} of its frame | in the first {TOP} | at all", by_kind(trials)))
    print(table("fault | found | with a remedy | mended | worse | IoU before | after", by_remedy(trials)))


if __name__ == "__main__":
    main()

"""`python -m tests.bench.corrections --with brush`: effort and effect of twelve corrections, or of twelve others.

Each is done on the extracted blocks of its frame, in the real window, without a display. The table has clicks, strokes
and keys; wrong pixels before and after, in the region of the correction; the number of pixels outside it whose block
changed; and the error against the ground truth over the hidden pixels of the region [mm], before, after, and with the
exact target, after a run of the blocks in the region. Zooming to the region is not counted. `--with strokes` and
`--with all` do the second twelve: by one stroke each, or also by Smart select and Refine edge.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QApplication

import ilf
from gui.state.session import Session
from ilf.evaluation.bench.patterns import Task
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between, redrawn

from . import brush, second, tools
from .driver import Driver
from .hand import Action
from .scenes import frames_folder, load_scene, their_network
from .targets import (
    CORRECTIONS_FILE,
    SECOND_FILE,
    Correction,
    Labels,
    Scene,
    read_corrections,
    target_map,
    wrong_pixels,
)

_HEAD = (
    f"{'frame':15}{'correction':24}{'clicks':>6}{'strokes':>8}{'keys':>5}{'wasted':>7}{'wrong pixels':>15}"
    f"{'outside':>9}{'hidden':>8}{'unfilled':>14}{'error [mm]':>19}{'exact':>8}"
)
WAYS: Mapping[str, tuple[Path, Mapping[str, Sequence[Action]]]] = {
    "brush": (CORRECTIONS_FILE, brush.ACTIONS),
    "tools": (CORRECTIONS_FILE, tools.ACTIONS),
    "strokes": (SECOND_FILE, second.STROKES),
    "all": (SECOND_FILE, second.ALL),
}
"""For each way of correcting, the corrections and the actions by their names."""


@dataclass(frozen=True)
class Outcome:
    """Effort and effect of a correction. Errors are in mm over `hidden` pixels; NaN where none has depth."""

    frame: str
    name: str
    clicks: int
    strokes: int
    keys: int
    wasted: int
    wrong_before: int
    wrong_after: int
    outside: int
    hidden: int
    unfilled_before: int
    unfilled_after: int
    error_before: float
    error_after: float
    error_exact: float


def main() -> int:
    """Do the corrections, print the table, write it."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.corrections", description="Effort and effect of twelve corrections."
    )
    parser.add_argument("--with", dest="way", choices=WAYS, default="brush", help="tools for the corrections")
    parser.add_argument("--only", default="", help="only corrections whose name contains this")
    parser.add_argument("--hand", type=int, default=0, help="seed of the hand's tremor")
    parser.add_argument("--out", type=Path, help="file for the table as JSON; corrections-WAY.json if left out")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of the window after each")
    options = parser.parse_args()
    folder = frames_folder()
    if not folder.is_dir():
        print(f"There are no frames in {folder}. Set ILF_TEST_DATA to the folder that contains rgbd/.", file=sys.stderr)
        return 1
    QApplication.setOrganizationName("ILF Studio")
    QApplication.setApplicationName("ilf-studio-bench")
    application = QApplication([])
    driver = Driver()
    outcomes = []
    print(_HEAD)
    for outcome in _walk(driver, folder, options.way, options.only, options.hand):
        outcomes.append(outcome)
        print(_row(outcome), flush=True)
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            driver.window.documents.picture().save(str(options.pictures / f"{outcome.name}.png"))
    driver.close()
    application.processEvents()
    if not outcomes:
        print(f"No correction's name contains {options.only!r}.", file=sys.stderr)
        return 1
    totals = _totals(outcomes)
    print(_last_line(len(outcomes), totals))
    target = options.out or Path(f"corrections-{options.way}.json")
    rows = [asdict(outcome) for outcome in outcomes]
    table = {"with": options.way, "hand": options.hand, "corrections": rows, "totals": totals}
    target.write_text(json.dumps(table, indent=1) + "\n")
    return 0


def _walk(driver: Driver, folder: Path, way: str, part: str, hand: int) -> Iterator[Outcome]:
    file, actions = WAYS[way]
    scenes, corrections = read_corrections(file)
    frames: dict[str, tuple[Task, Run]] = {}
    for correction in corrections:
        if part not in correction.name:
            continue
        if correction.frame not in frames:
            frames[correction.frame] = _open(
                scenes[correction.frame], folder, nullcontext if file == SECOND_FILE else their_network
            )
        yield _correct(driver, *frames[correction.frame], correction, actions[correction.name], hand)


def _open(scene: Scene, folder: Path, network: Callable[[], AbstractContextManager[None]]) -> tuple[Task, Run]:
    task = load_scene(scene, folder)
    with network():
        run = Run.of(task.frame)
    found = hashlib.sha256(run.blocks.astype("<i4").tobytes()).hexdigest()
    if not found.startswith(scene.labels):
        print(f"{scene.name}: the blocks have changed since the corrections were selected.", file=sys.stderr)
    return task, run


def _correct(
    driver: Driver, task: Task, run: Run, correction: Correction, actions: Sequence[Action], hand: int
) -> Outcome:
    session = driver.open(run, correction)
    before = session.labels.copy()
    target = target_map(before, correction)
    untouched = _completed(session, correction)
    count = driver.do(actions, f"{correction.name}, hand {hand}")
    after = session.labels.copy()
    depth = _completed(session, correction)
    exact = _completed(_met(run, target), correction)
    box = correction.box
    hidden = np.zeros(task.scored.shape, bool)
    hidden[box] = task.scored[box]
    common = hidden & np.isfinite(untouched) & np.isfinite(depth)
    elsewhere = (after != before) & (target == before)
    elsewhere[box] = False
    return Outcome(
        correction.frame,
        correction.name,
        count.clicks,
        count.strokes,
        count.keys,
        count.wasted,
        int(wrong_pixels(before, target, correction).sum()),
        int(wrong_pixels(after, target, correction).sum()),
        int(elsewhere.sum()),
        int(hidden.sum()),
        int((hidden & ~np.isfinite(untouched)).sum()),
        int((hidden & ~np.isfinite(depth)).sum()),
        *(_error(found, task.ground_truth, common & np.isfinite(exact)) for found in (untouched, depth, exact)),
    )


def _met(run: Run, target: Labels) -> Session:
    """Return a session with the target's blocks; borders that changed are drawn borders."""
    drawn = np.zeros(target.shape, bool)
    patch = patch_between(run.blocks, target)
    if patch is not None:
        box, pixels = redrawn(None, target, patch)
        drawn[box] = pixels
    return Session.of(replace(run, blocks=target, drawn=drawn, edited=True), None, "exact")


def _completed(session: Session, correction: Correction) -> NDArray[np.float32]:
    """Return the depth after a run of the blocks in the region with the default preset."""
    chosen = {int(label) for label in np.unique(session.labels[correction.box]) if label > 0}
    return session.run(ilf.preset(), chosen).complete().depth


def _error(depth: NDArray[np.float32], ground_truth: NDArray[np.float32], where: NDArray[np.bool_]) -> float:
    """Root mean square error in mm."""
    if not where.any():
        return math.nan
    return float(1000 * np.sqrt(np.mean((depth[where].astype(float) - ground_truth[where]) ** 2)))


def _row(one: Outcome) -> str:
    return (
        f"{one.frame:15}{one.name:24}{one.clicks:6}{one.strokes:8}{one.keys:5}{one.wasted:7}"
        f"{one.wrong_before:7} ->{one.wrong_after:5}{one.outside:9}"
        f"{one.hidden:8}{one.unfilled_before:6} ->{one.unfilled_after:5}"
        f"{one.error_before:9.1f} ->{one.error_after:7.1f}{one.error_exact:8.1f}"
    )


def _totals(outcomes: Sequence[Outcome]) -> dict[str, float]:
    counts = ("clicks", "strokes", "keys", "wasted", "wrong_before", "wrong_after", "outside")
    sums = {name: sum(getattr(one, name) for one in outcomes) for name in counts}
    errors = ("error_before", "error_after", "error_exact")
    return sums | {name: float(np.nanmean([getattr(one, name) for one in outcomes])) for name in errors}


def _last_line(number: int, total: Mapping[str, float]) -> str:
    inputs = f"{total['clicks']} clicks, {total['strokes']} strokes, {total['keys']} keys, {total['wasted']} in vain"
    return (
        f"{number} corrections: {inputs}; wrong pixels {total['wrong_before']} -> {total['wrong_after']}, "
        f"{total['outside']} outside; mean error {total['error_before']:.1f} -> {total['error_after']:.1f} mm, "
        f"exact {total['error_exact']:.1f} mm"
    )


if __name__ == "__main__":
    sys.exit(main())

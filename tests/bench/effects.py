"""Reliability of the edit summary: `python -m tests.bench.effects [--seed N]`.

Blocks of frames with filled depth (NYU, under ILF_TEST_DATA) get a fault in one place (`tests.bench.quality_checks`),
which is then repaired: two edits. For each, the change of the hold-out error near the border
(`ilf.run.summarise_edit`) is compared with that of the true error in the holes nearby. An edit counts if both changes
are large enough.
"""

from __future__ import annotations

import argparse
import os
import zlib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ilf import BlockParameters, extract_blocks, load_frame
from ilf.evaluation.edit_summary import summarise_edit
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between, redrawn

from .quality_checks.__main__ import EVALUATION_FRAMES
from .quality_checks.faults import KINDS, Mask, make_faults, with_holes

_VERDICTS = "right", "wrong", "right beyond the margin", "wrong beyond the margin", "undecided"

MIN_CHANGE, MIN_TRUE_CHANGE = 0.02, 0.03
"""Smaller relative changes are ignored: of the hold-out error, and of the true error."""


def main() -> None:
    """Print how often the changes agree."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    root = Path(os.environ.get("ILF_TEST_DATA", "../shared/data")) / "rgbd"
    found: Counter[tuple[str, str]] = Counter()
    for name in EVALUATION_FRAMES:
        folder = root / f"nyufilled_{name}"
        ground_truth = load_frame(folder / "rgb.jpg", folder / "gt.png", depth_units=1000, name=folder.name)
        rng = np.random.default_rng([arguments.seed, zlib.crc32(ground_truth.name.encode())])
        frame = with_holes(ground_truth, rng)
        right = Run(frame, extract_blocks(ground_truth, BlockParameters(min_size=0.1)), edited=True)
        for kind in KINDS:
            spoilt, faults = make_faults(right.blocks, ground_truth.depth, ~frame.known, [kind], rng)
            for fault in faults:
                wrong = replace(right, blocks=spoilt)
                for way, before, after in (("spoilt", right, wrong), ("mended", wrong, right)):
                    found[way, _verdict(before, after, ground_truth.depth, fault.zone)] += 1
    for way in ("spoilt", "mended"):
        print(f"{way:8}", ", ".join(f"{what} {found[way, what]}" for what in _VERDICTS))


def _verdict(before: Run, after: Run, ground_truth: NDArray[np.float32], zone: Mask) -> str:
    patch = patch_between(before.blocks, after.blocks)
    if patch is None:
        return "undecided"
    box, pixels = redrawn(None, after.blocks, patch)
    drawn = np.zeros(after.blocks.shape, bool)
    drawn[box] = pixels
    after = replace(after, drawn=drawn)
    there = zone & ~before.frame.known
    blocks = frozenset(np.unique([*before.blocks[there], *after.blocks[there]]).tolist()) - {0}
    depths = [replace(run, only=blocks).complete().depth for run in (before, after)]
    there &= np.isfinite(depths[0]) & np.isfinite(depths[1])
    true = [float(np.mean(np.abs(depth[there] - ground_truth[there]))) for depth in depths]
    summary = summarise_edit(before, after, patch)
    hidden = summary.held_out
    if hidden is None or _same(*true, MIN_TRUE_CHANGE) or _same(*hidden, MIN_CHANGE):
        return "undecided"
    agrees = (hidden[1] < hidden[0]) == (true[1] < true[0])
    return f"{'right' if agrees else 'wrong'}{' beyond the margin' if summary.held_out_differs else ''}"


def _same(one: float, other: float, least: float) -> bool:
    return abs(one - other) < least * max(one, other)


if __name__ == "__main__":
    main()

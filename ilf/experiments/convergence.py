"""The paper's curves, Fig. 2 and 3: how the iteration of one block goes on, with and without colour."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..assets import asset_path
from ..bench.frames import load_bench_frame
from ..blocks import Block, find_blocks
from ..completion import iterate
from ..ebs import extract_blocks
from ..errors import InputError
from ..filter.convergence import IterationRecord
from ..filter.pass_band.record import PassBandRecord
from ..frame import RGBDFrame
from ..parameters import PAPER_BLOCKS, PRESETS, Parameters
from .experiment import METHOD_PRESETS, OnProgress, Result, Row, Settings, preset_parameters
from .sources import SAMPLE
from .units import run_counted

_SOFA = 350, 560
"""A pixel (row, column) of the bundled sample's sofa, the curved surface that is shown."""

_HIDDEN = 0.5
"""Share of its pixels that are hidden: whole columns in the middle."""

_QUICK_EVERY = 25
"""A quick run looks at the surface once in so many iterations."""


def run_convergence(settings: Settings, on_progress: OnProgress) -> Result:
    """Iterate on one block of the bundled sample, with every preset, with and without colour."""
    every = _QUICK_EVERY if settings.quick else 1
    units = [(name, colour, every) for name in METHOD_PRESETS for colour in (True, False)]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    frame, _, block, _ = _block()
    raw = frame.depth[block.box][block.mask]
    return Result(
        rows=[row for row, _ in parts],
        parameters={
            "frame": frame.name,
            "block": block.label,
            "block_pixels": int(raw.size),
            "defect_rate": float(np.isnan(raw).mean()),
            "extraction": PAPER_BLOCKS.to_dict(),
            "presets": preset_parameters(),
            "chosen": "The paper's block is not published. Here: the sofa of the bundled sample, a generated room with "
            f"exact truth, of which whole columns in the middle ({_HIDDEN:.0%} of the pixels) are hidden besides what "
            "the simulated sensor misses. Without colour means: no weighted spectrum (paper, released-code), or a grey "
            "image (best).",
        },
        notes=[
            "L1 and sigma_i are those of the whole block, the mean absolute error (MAE) that of its defective area "
            "against the exact truth. A glitch is an iteration whose pass band is larger than that of the one before "
            "and in which the L1 norm rises, by more than it did in the one before.",
        ],
        tables={"curves": [row for _, curve in parts for row in curve]},
    )


def _block() -> tuple[RGBDFrame, NDArray[np.int32], Block, NDArray[np.float64]]:
    """The frame with the block's middle hidden, the label map, the block, and its true depth [m]."""
    source = load_bench_frame(asset_path(SAMPLE))
    if source.truth is None:
        raise InputError(f"The bundled {SAMPLE} has no truth. Install ilf-studio again.")
    labels = extract_blocks(source.frame, PAPER_BLOCKS)
    label = int(labels[_SOFA])
    if label == 0:
        raise InputError(f"The bundled {SAMPLE} has no block at {_SOFA}. Install ilf-studio again.")
    inside = labels == label
    low, high = np.quantile(np.nonzero(inside)[1], [(1 - _HIDDEN) / 2, (1 + _HIDDEN) / 2])
    columns = np.arange(inside.shape[1])
    hidden = inside & (columns >= low) & (columns < high)
    frame = source.frame
    gapped = RGBDFrame(frame.rgb, np.where(hidden, np.nan, frame.depth), frame.intrinsics, frame.name)
    block = find_blocks(labels)[label]
    return gapped, labels, block, source.truth[block.box][block.mask].astype(np.float64)


def _run_unit(name: str, colour: bool, every: int) -> tuple[Row, list[Row]]:
    frame, labels, block, truth = _block()
    parameters = PRESETS[name]
    if not colour:
        frame, parameters = _colourless(frame, parameters)
    missing = np.isnan(frame.depth[block.box][block.mask])
    started = time.perf_counter()
    steps = iterate(frame, labels, block.label, parameters)
    records: list[IterationRecord] = []
    errors: list[float | None] = []
    for record in steps:
        records.append(record)
        looked = record.i % every == 0 or record.i == 1
        errors.append(_mae(steps.surface, truth, missing) if looked else None)
    errors[-1] = _mae(steps.surface, truth, missing)
    seconds = time.perf_counter() - started
    enlarged, glitches, sigma_jumps = _events(records)
    curve: list[Row] = [
        {
            "method": name,
            "colour": colour,
            "i": record.i,
            "stage": record.stage,
            "radius_y": record.radii[0] if isinstance(record, PassBandRecord) else None,
            "sigma_mm": 1000 * record.sigma_i,
            "l1_m": record.l1,
            "mae_mm": error,
            "glitch": place in glitches,
        }
        for place, (record, error) in enumerate(zip(records, errors, strict=True))
    ]
    looked_at = [row for row in curve if row["mae_mm"] is not None]
    least = min(looked_at, key=lambda row: row["mae_mm"])
    return {
        "method": name,
        "colour": colour,
        "defect_rate": float(missing.mean()),
        "iterations": len(records),
        "weighted_iterations": sum(isinstance(record, PassBandRecord) and record.weighted for record in records),
        "enlargements": len(enlarged),
        "sigma_jumps": len(sigma_jumps),
        "glitches": len(glitches),
        "fallen_back": _fallen_back(records, enlarged, glitches),
        "last_sigma_mm": 1000 * records[-1].sigma_i,
        "mae_mm": errors[-1],
        "least_mae_mm": least["mae_mm"],
        "least_mae_at": least["i"],
        "settled": steps.settled,
        "seconds": seconds,
    }, curve


def _colourless(frame: RGBDFrame, parameters: Parameters) -> tuple[RGBDFrame, Parameters]:
    grey = RGBDFrame(np.full_like(frame.rgb, 128), frame.depth, frame.intrinsics, frame.name)
    return grey, parameters.replace(rgb_iterations=0)


def _mae(surface: NDArray[np.float64], truth: NDArray[np.float64], missing: NDArray[np.bool_]) -> float:
    return 1000 * float(np.mean(np.abs(surface - truth)[missing]))


def _events(records: Sequence[IterationRecord]) -> tuple[list[int], set[int], list[int]]:
    """Places of records that begin a stage, with a larger pass band; of these, where L1 jumps up, and where sigma_i
    does."""
    enlarged = [place for place, (a, b) in enumerate(itertools.pairwise(records), 1) if b.stage > a.stage]
    sigma_jumps = [place for place in enlarged if records[place].sigma_i > records[place - 1].sigma_i]
    rises = [0.0, *(b.l1 - a.l1 for a, b in itertools.pairwise(records))]
    glitches = {place for place in enlarged if rises[place] > max(rises[place - 1], 0.0)}
    return enlarged, glitches, sigma_jumps


def _fallen_back(records: Sequence[IterationRecord], enlarged: Sequence[int], glitches: set[int]) -> int:
    """Number of glitches after which L1 falls before the pass band grows again."""
    ends = dict(zip(enlarged, [*enlarged[1:], len(records)], strict=True))
    return sum(any(b.l1 < a.l1 for a, b in itertools.pairwise(records[place : ends[place]])) for place in glitches)

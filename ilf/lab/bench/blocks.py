"""Bench of block methods: extract blocks of many frames and score them."""

from __future__ import annotations

import dataclasses
import os
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._runtime.installation import optional
from ..._runtime.processes import run_units
from ...data.frame import RGBDFrame
from ...data.parameters import PAPER_BLOCKS
from ...errors import IlfError, InputError
from ...segmentation.extraction import extract
from .block_measures import BlockScore, Evidence, find_reference, margin_window, score_blocks
from .frames import load_bench_frame, parse_names
from .results import records, write_content, write_table

# The block methods that the bench compares: variants of EBS, and two public segmentations.

Labels = NDArray[np.int32]


@dataclass(frozen=True)
class BlockMethod:
    """A method that makes blocks.

    Attributes
    ----------
    run : callable
        Takes a frame, returns its label map int32 (H, W), 0 = no block.
    settings : mapping
        All settings that the result depends on, by name.
    """

    run: Callable[[RGBDFrame], Labels]
    settings: Mapping[str, Any]


def _ebs(**changes: Any) -> BlockMethod:
    """EBS with contours and default parameters, except for the given changes."""
    parameters = PAPER_BLOCKS.replace(**changes)

    def run(frame: RGBDFrame) -> Labels:
        extraction = extract(frame, parameters)
        if extraction.notes:
            raise InputError(" ".join(extraction.notes))
        return extraction.blocks

    return BlockMethod(run, parameters.to_dict())


def _public(segment: Callable[..., NDArray[np.integer]], **settings: Any) -> BlockMethod:
    """A segmentation of the colour inside the margins; its labels are unchanged, from 1 on."""

    def run(frame: RGBDFrame) -> Labels:
        window = margin_window(frame.rgb)
        labels = np.zeros(frame.shape, np.int32)
        _, regions = np.unique(segment(frame.rgb[window], **settings), return_inverse=True)
        labels[window] = regions.reshape(labels[window].shape) + 1
        return labels

    return BlockMethod(run, settings)


def _felzenszwalb(rgb: NDArray[np.uint8], scale: float, sigma: float, min_share: float) -> NDArray[np.integer]:
    from skimage.segmentation import felzenszwalb

    return felzenszwalb(rgb, scale=scale, sigma=sigma, min_size=round(min_share * rgb.shape[0] * rgb.shape[1]))


def _slic_merged(rgb: NDArray[np.uint8], segments: int, compactness: float, merged_below: float) -> NDArray[np.integer]:
    """Superpixels, merged with neighbours whose mean RGB (0-255) differs by less than `merged_below`."""
    from skimage.graph import cut_threshold, rag_mean_color
    from skimage.segmentation import slic

    superpixels = slic(rgb, n_segments=segments, compactness=compactness, start_label=1)
    return cut_threshold(superpixels, rag_mean_color(rgb, superpixels, connectivity=1), merged_below)


# Of several settings tried on seven real frames, those of the public methods gave the highest boundary F.
BLOCK_METHODS: dict[str, BlockMethod] = {
    "canny": _ebs(detector="canny", use_depth=False),
    "network": _ebs(use_depth=False),
    "canny+depth": _ebs(detector="canny"),
    "combined": _ebs(),
    "felzenszwalb": _public(_felzenszwalb, scale=400.0, sigma=0.8, min_share=0.004),
    "slic": _public(_slic_merged, segments=400, compactness=30.0, merged_below=29.0),
}
"""Name -> method, those of EBS first."""


def parse_block_methods(names: str) -> list[str]:
    """Parse a comma-separated list of methods, each named once; "all" means all.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    return parse_names(names, BLOCK_METHODS, {"all": tuple(BLOCK_METHODS)})


@dataclass(frozen=True)
class BlockPlan:
    """Input of the block bench: frame folders, and names of methods."""

    folders: tuple[Path, ...]
    methods: tuple[str, ...]


@dataclass(frozen=True)
class BlockRow(BlockScore):
    """One method on one frame: score, seconds of the extraction, and reason of a failure ("" if none)."""

    frame: str
    method: str
    seconds: float
    failure: str


@dataclass(frozen=True)
class SkippedFrame:
    """A skipped frame, and the reason."""

    frame: str
    reason: str


@dataclass(frozen=True)
class BlockBenchResult:
    """All rows, by frame and method in the order of the plan, and the skipped frames."""

    plan: BlockPlan
    rows: tuple[BlockRow, ...]
    skipped: tuple[SkippedFrame, ...]


def run_block_bench(
    plan: BlockPlan, *, jobs: int = 1, on_progress: Callable[[str], None] | None = None
) -> BlockBenchResult:
    """Run every method on every frame, with all of its depth.

    No depth is held out: methods that use depth get the depth that they are scored with, as they do when the frame is
    completed.

    Parameters
    ----------
    plan : BlockPlan
    jobs : int
        Processes that share the frames. More than one makes the timings longer and less accurate; all else stays.
    on_progress : callable, optional
        Called with a frame's name whenever it is done.

    Raises
    ------
    InputError
        If the package of the public methods is missing.
    """
    if not {"felzenszwalb", "slic"}.isdisjoint(plan.methods):
        optional("skimage", "ilf-studio[plot]", "A comparison with felzenszwalb or slic")  # fail before the work
    report = on_progress or (lambda name: None)
    units = [(folder, plan.methods) for folder in plan.folders]
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: report(units[number][0].name))
    rows = tuple(row for part in parts if not isinstance(part, SkippedFrame) for row in part)
    return BlockBenchResult(plan, rows, tuple(part for part in parts if isinstance(part, SkippedFrame)))


def _run_unit(folder: Path, methods: Sequence[str]) -> list[BlockRow] | SkippedFrame:
    try:
        frame = load_bench_frame(folder).frame
    except IlfError as error:
        return SkippedFrame(folder.name, str(error))
    evidence = find_reference(frame)
    return [_run_method(method, frame, evidence) for method in methods]


def _run_method(name: str, frame: RGBDFrame, evidence: Evidence) -> BlockRow:
    failure = ""
    started = time.perf_counter()
    try:
        labels = BLOCK_METHODS[name].run(frame)
    except (IlfError, MemoryError) as error:
        labels, failure = np.zeros(frame.shape, np.int32), str(error) or type(error).__name__
    seconds = time.perf_counter() - started
    score = dataclasses.asdict(score_blocks(labels, evidence))
    return BlockRow(frame=frame.name, method=name, seconds=seconds, failure=failure, **score)


# Results of the block bench: summarised, and written as CSV and JSON.


@dataclass(frozen=True)
class BlockSummary:
    """One method over all frames: median of the seconds, and means of all else over the frames that have a value.

    `watertight` is the share of the frames without a leak; `failures` counts the frames on which the method failed;
    these count as having no blocks.
    """

    method: str
    frames: int
    failures: int
    coverage: float
    frame_coverage: float
    recoverable: float | None
    watertight: float
    purity: float | None
    cut_rate: float | None
    recall: float | None
    precision: float | None
    f: float | None
    blocks: float
    seconds: float


def summarise_blocks(result: BlockBenchResult) -> list[BlockSummary]:
    """Return one summary per method, the highest boundary F first."""
    by_method = [[row for row in result.rows if row.method == method] for method in result.plan.methods]
    lines = [_summary(rows) for rows in by_method if rows]
    return sorted(lines, key=lambda line: -1.0 if line.f is None else line.f, reverse=True)


def write_block_csv(path: str | os.PathLike[str], result: BlockBenchResult) -> None:
    """Write the table, atomically; raises ExportError if that fails."""
    write_table(path, BlockSummary, summarise_blocks(result))


def write_block_json(path: str | os.PathLike[str], result: BlockBenchResult) -> None:
    """Write the table, the row of every frame, and the methods' settings; raises ExportError if that fails."""
    content = {
        "frames": list(dict.fromkeys(row.frame for row in result.rows)),
        "methods": {name: dict(BLOCK_METHODS[name].settings) for name in result.plan.methods},
        "table": records(summarise_blocks(result)),
        "rows": records(result.rows),
        "skipped": records(result.skipped),
    }
    write_content(path, content)


def _summary(rows: Sequence[BlockRow]) -> BlockSummary:
    def mean(value: Callable[[BlockRow], float | None]) -> float | None:
        values = [found for found in map(value, rows) if found is not None]
        return statistics.fmean(values) if values else None

    return BlockSummary(
        method=rows[0].method,
        frames=len(rows),
        failures=sum(bool(row.failure) for row in rows),
        coverage=statistics.fmean(row.coverage for row in rows),
        frame_coverage=statistics.fmean(row.frame_coverage for row in rows),
        recoverable=mean(lambda row: row.recoverable),
        watertight=statistics.fmean(row.leaks == 0 for row in rows),
        purity=mean(lambda row: row.purity),
        cut_rate=mean(lambda row: row.cut_rate),
        recall=mean(lambda row: row.recall),
        precision=mean(lambda row: row.precision),
        f=mean(lambda row: row.f),
        blocks=statistics.fmean(row.blocks for row in rows),
        seconds=statistics.median(row.seconds for row in rows),
    )

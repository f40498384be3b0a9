"""Bench of block methods: extract blocks of many frames and score them."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._runtime.children import run_units
from ..._runtime.installation import optional
from ...data.frame import RGBDFrame
from ...data.parameters import PAPER_BLOCKS
from ...errors import IlfError, InputError
from ...segmentation.extraction import extract
from .block_measures import Labels, find_reference, margin_window, score_blocks
from .frames import load_bench_frame
from .results import Line, Skipped, mean
from .runner import timed


class BlockMethod(NamedTuple):
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


def run_block_bench(
    folders: Sequence[Path],
    methods: Sequence[str],
    *,
    jobs: int = 1,
    on_progress: Callable[[str], None] = lambda name: None,
) -> tuple[list[Line], list[Skipped]]:
    """Run every method on every frame, with all of its depth.

    No depth is held out: methods that use depth get the depth that they are scored with, as they do when the frame is
    completed.

    Parameters
    ----------
    folders : sequence of Path
        Frame folders.
    methods : sequence of str
        Of `BLOCK_METHODS`.
    jobs : int
        Processes that share the frames. More than one makes the timings longer and less accurate; all else stays.
    on_progress : callable, optional
        Called with a frame's name whenever it is done.

    Returns
    -------
    rows : list of dict
        Frame, method, seconds, reason of a failure, which counts as no blocks ("" if none), and `score_blocks`, by
        frame and method.
    skipped : list of Skipped

    Raises
    ------
    InputError
        If the package of the public methods is missing.
    """
    if not {"felzenszwalb", "slic"}.isdisjoint(methods):
        optional("skimage", "ilf-studio[plot]", "A comparison with felzenszwalb or slic")  # fail before the work
    units = [(folder, methods) for folder in folders]
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: on_progress(folders[number].name))
    rows = [row for part in parts if not isinstance(part, Skipped) for row in part]
    return rows, [part for part in parts if isinstance(part, Skipped)]


def _run_unit(folder: Path, methods: Sequence[str]) -> list[Line] | Skipped:
    try:
        frame = load_bench_frame(folder).frame
    except IlfError as error:
        return Skipped(folder.name, "", str(error))
    evidence, rows = find_reference(frame), []
    for method in methods:
        run = partial(BLOCK_METHODS[method].run, frame)
        labels, seconds, failure = timed(run, np.zeros(frame.shape, np.int32))
        facts = {"frame": frame.name, "method": method, "seconds": seconds, "failure": failure}
        rows.append(facts | score_blocks(labels, evidence))
    return rows


def summarise_blocks(rows: Sequence[Line]) -> list[Line]:
    """Return one line per method, the highest boundary F first.

    Values are means over the frames that have one; seconds are medians. `watertight` is the share of the frames without
    a leak; `failures` counts the frames on which the method failed.
    """
    lines = []
    for method in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == method]
        lines.append(
            {
                "method": method,
                "frames": len(own),
                "failures": sum(bool(row["failure"]) for row in own),
                **{name: mean(row[name] for row in own) for name in ("coverage", "frame_coverage", "recoverable")},
                "watertight": mean(row["leaks"] == 0 for row in own),
                **{name: mean(row[name] for row in own) for name in ("purity", "cut_rate", "recall", "precision", "f")},
                "blocks": mean(row["blocks"] for row in own),
                "seconds": statistics.median(row["seconds"] for row in own),
            }
        )
    return sorted(lines, key=lambda line: -1.0 if line["f"] is None else line["f"], reverse=True)

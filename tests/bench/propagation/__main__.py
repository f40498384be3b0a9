"""`python -m tests.bench.propagation`: propagation of blocks over 30 frames, compared with copying and extraction.

The generated room is rendered with a camera that orbits, one that moves forward, and one that stands still (each frame
has its own noise), and real frames are viewed by a rotating camera. Blocks are propagated from frame to frame, never
directly from the first; a pixel is right if it has the block that the first frame has at the same point. The blocks of
new extractions get their labels from the ground truth, which no method has.

Marked blocks are those that any frame since the first marked "to check"; their recall includes pixels whose block was
decided again in the last frame. Pictures take about 7 s each to render, and stay in --cache.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ilf.data.parameters import BlockParameters
from ilf.segmentation.extraction import extract
from ilf.segmentation.propagation.propagate import Followed, follow

from .sequences import Moment, rendered, turned_views

AFTER = (1, 5, 10, 30)
REAL = ("nyu_0433", "nyu_0464", "lingbot_1")
Labels = NDArray[np.int32]


@dataclass
class Score:
    """Result of one frame: shares of the evaluated pixels, and seconds.

    Attributes
    ----------
    right : float
        Pixels with the right block.
    marked : float
        Pixels in blocks that are marked "to check".
    precision, recall : float
        Share of the pixels in marked blocks that are wrong, and share of the wrong ones that are in marked blocks or
        decided again.
    seconds : float
        Time of the propagation, without finding the frame's edges, which extraction needs as well.
    """

    right: float
    marked: float = np.nan
    precision: float = np.nan
    recall: float = np.nan
    seconds: float = np.nan


def ground_truth_of(moment: Moment, first: Moment, labels: Labels) -> tuple[Labels, NDArray[np.bool_]]:
    """Return the right block of every pixel, and where it is known."""
    by_point = np.where(moment.first >= 0, labels.ravel()[np.maximum(moment.first, 0)], 0)
    known = by_point > 0
    if np.array_equal(labels, first.surface):  # including surfaces that were outside the picture
        known = (moment.surface > 0) & np.isin(moment.surface, np.unique(first.surface))
        by_point = moment.surface
    return by_point.astype(np.int32), known


def chain(moments: list[Moment], labels: Labels, how: str) -> Iterator[tuple[Followed, float]]:
    """Propagate blocks from frame to frame."""
    taken: set[int] = set()
    for before, after in itertools.pairwise(moments):
        extract(after.frame, BlockParameters())
        begun = time.process_time()
        pose = after.pose @ np.linalg.inv(before.pose) if how == "pose" else None
        found = follow(before.frame, labels, after.frame, how=how, pose=pose, taken=taken)
        yield found, time.process_time() - begun
        labels = found.labels
        taken |= set(np.unique(labels).tolist())


def scores_of_propagation(moments: list[Moment], labels: Labels, how: str) -> list[Score]:
    """Results of every frame except the first."""
    scores = []
    marked: set[int] = set()
    for after, (found, seconds) in zip(moments[1:], chain(moments, labels, how), strict=True):
        ground_truth, known = ground_truth_of(after, moments[0], labels)
        marked |= found.to_check
        wrong = (found.labels != ground_truth)[known]
        looked = np.isin(found.labels, list(marked))[known]
        said = looked | found.uncertain[known]
        scores.append(
            Score(
                1 - wrong.mean(),
                looked.mean(),
                wrong[looked].mean() if looked.any() else np.nan,
                said[wrong].mean() if wrong.any() else np.nan,
                seconds,
            )
        )
    return scores


def scores_of_copying(moments: list[Moment], labels: Labels) -> list[Score]:
    """Copy the label map of the first frame."""
    return [_plain(labels, after, moments[0], labels) for after in moments[1:]]


def scores_of_extraction(moments: list[Moment], labels: Labels) -> list[Score]:
    """Extract every frame's blocks, each labelled by the right block of most of its pixels."""
    return [
        _plain(
            _named(extract(after.frame, BlockParameters()).blocks, *ground_truth_of(after, moments[0], labels)), *rest
        )
        for after, *rest in ((after, after, moments[0], labels) for after in moments[1:])
    ]


def _plain(found: Labels, after: Moment, first: Moment, labels: Labels) -> Score:
    ground_truth, known = ground_truth_of(after, first, labels)
    return Score(float((found == ground_truth)[known].mean()))


def _named(blocks: Labels, ground_truth: Labels, known: NDArray[np.bool_]) -> Labels:
    counts = np.zeros((int(blocks.max()) + 1, int(ground_truth.max()) + 1), np.int64)
    np.add.at(counts, (blocks[known], ground_truth[known]), 1)
    return counts.argmax(axis=1)[blocks].astype(np.int32)


def report(name: str, moments: list[Moment], labels: Labels) -> None:
    """Print one line for each way."""
    ways: dict[str, Callable[[], list[Score]]] = {
        "carried, flow": lambda: scores_of_propagation(moments, labels, "flow"),
        "carried, pose": lambda: scores_of_propagation(moments, labels, "pose"),
        "carried, auto": lambda: scores_of_propagation(moments, labels, "auto"),
        "copied": lambda: scores_of_copying(moments, labels),
        "extracted anew": lambda: scores_of_extraction(moments, labels),
    }
    print(f"\n{name}: {np.unique(labels[labels > 0]).size} blocks, {labels.shape[1]} x {labels.shape[0]}")
    head = "".join(f"{f'after {k}':>10s}" for k in AFTER)
    print(f"{'':16s}{head}    marked  precision  recall  ms of computing")
    for way, scores_of in ways.items():
        scores = scores_of()
        line = f"{way:16s}" + "".join(f"{scores[k - 1].right:10.1%}" for k in AFTER if k <= len(scores))
        last = scores[min(AFTER[-1], len(scores)) - 1]
        if way.startswith("propagated"):
            took = np.median([one.seconds for one in scores]) * 1000
            line += f"{last.marked:10.1%}{last.precision:11.0%}{last.recall:8.0%}{took:17.0f}"
        print(line, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "ilf-following")
    parser.add_argument(
        "--frames", type=Path, default=Path("../shared/data/rgbd"), help="real frames, if there are any"
    )
    parser.add_argument("--length", type=int, default=31)
    parser.add_argument("--seed", type=int, default=7, help="seed of the room; parameters were tuned with 7")
    parser.add_argument("--only", nargs="+", default=["orbit", "dolly", "still", *REAL])
    parser.add_argument("--starts", nargs="+", default=["surfaces", "extracted"])
    options = parser.parse_args()
    for name in options.only:
        if name in REAL:
            if (options.frames / name).is_dir():
                moments = turned_views(options.frames / name, options.length)
                report(f"rotation in {name}, extracted", moments, extract(moments[0].frame).blocks)
            continue
        moments = rendered(name, options.cache, options.length, options.seed)
        for start in options.starts:
            labels = moments[0].surface if start == "surfaces" else extract(moments[0].frame).blocks
            report(f"{name}, {start}", moments, labels)


if __name__ == "__main__":
    main()

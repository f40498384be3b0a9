"""Samples of the correction of sparse depth: frames of which few pixels are kept, completed and corrected once."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.completion.correction import UNCORRECTED, CorrectionNetwork, applied_change, fading
from ilf.completion.sparse_correction import middles_of_cells, sparse_features
from ilf.data.blocks import SPARSE
from ilf.data.frame import RGBDFrame
from ilf.errors import InputError
from ilf.evaluation.bench.frames import load_bench_frame
from ilf.run.run import complete
from ilf.segmentation.edges.frame_edges import edges_for
from ilf.segmentation.extraction import extract_blocks

from .simulated import RENDERED, simulated

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

FROM_EACH, FROM_PICTURE = 7, 3
"""Samples of each frame, and of each generated picture."""

MEASURED, EXACT = "measured-", "exact-"
"""What the names of samples begin with: of frames measured by sensors, and of those with exact depth."""

HELD_OUT_SHARE = 12
"""One frame of so many is held out, by its name."""

_POINTS, _CORNERS, _FEWEST_ROWS = (150, 6000), (150, 2000), 6
"""Ranges of the number of single pixels and of corners of the image, and the fewest rows."""

_LEAST = 60
"""Fewer known pixels, or fewer cells to learn from, make no sample."""

_LARGEST, _SIZE = 800, 640
"""Frames with a longer side above the first [px] are scaled to the second."""


def kept_pixels(frame: RGBDFrame, rng: np.random.Generator) -> Mask:
    """Select known pixels that a sample keeps: single ones, rows as of a lidar, or corners as of a feature tracker."""
    height, width = frame.shape
    kept = np.zeros(frame.shape, bool)
    kind = rng.random()
    if kind < 0.4:
        count = _between(_POINTS, rng)
        kept.ravel()[rng.permutation(np.flatnonzero(frame.known))[:count]] = True
    elif kind < 0.85:
        count = _between((_FEWEST_ROWS, int(SPARSE * height)), rng)
        rows = ((np.arange(count) + rng.random()) * height / count).astype(int)
        kept[rows] = frame.known[rows]
        if rng.random() < 0.5:
            kept &= rng.random(width)[None] < rng.uniform(0.15, 1)
    else:
        grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
        corners = cv2.goodFeaturesToTrack(grey, _between(_CORNERS, rng), 0.003, 4)
        if corners is not None:
            noise = rng.normal(0, 1, (len(corners), 2))
            columns, rows = np.clip(np.rint(corners[:, 0] + noise), 0, (width - 1, height - 1)).astype(int).T
            kept[rows, columns] = frame.known[rows, columns]
    return kept


def _between(limits: tuple[int, int], rng: np.random.Generator) -> int:
    return int(np.exp(rng.uniform(*np.log(limits))))


@dataclass(frozen=True)
class Sample:
    """Cells of a frame: features, float16 (24, h, w); true and corrected depth [m], (h, w), the true one NaN where it
    is not to be learnt; and the factor on changes, (h, w)."""

    features: Array
    true: Array
    corrected: Array
    fading: Array

    def save(self, path: Path) -> None:
        """Write the sample; the file appears whole."""
        unfinished = path.with_suffix(".new")
        with unfinished.open("wb") as file:
            np.savez_compressed(file, **vars(self))
        unfinished.replace(path)

    @classmethod
    def load(cls, path: Path) -> Sample:
        """Read a sample; raise InputError if the file is not one."""
        try:
            with np.load(path) as file:
                features, *others = (file[name] for name in cls.__dataclass_fields__)
                return cls(features, *(one.astype(np.float32) for one in others))
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"{path} is not a sample. Make it again.") from error


def make_sample(path: Path, number: int) -> Sample | None:
    """Make one of the samples of a frame's folder or of a generated picture; None if it would have too little depth."""
    rng = np.random.default_rng((number, zlib.crc32(path.name.encode())))
    rgb, depth, measured = _taken(path, rng)
    if max(depth.shape) > _LARGEST:
        height, width = (round(side * _SIZE / max(depth.shape)) for side in depth.shape)
        rgb = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA)
        depth, measured = (
            cv2.resize(one, (width, height), interpolation=cv2.INTER_NEAREST) for one in (depth, measured)
        )
    if rng.random() < 0.5:
        rgb, depth, measured = (np.ascontiguousarray(one[:, ::-1]) for one in (rgb, depth, measured))
    kept = kept_pixels(RGBDFrame(rgb, measured), rng)
    if kept.sum() < _LEAST:
        return None
    sparse = RGBDFrame(rgb, np.where(kept, measured, np.float32(np.nan)))
    completed = complete(sparse, extract_blocks(sparse), UNCORRECTED, threads=1).depth
    edges = edges_for(sparse, UNCORRECTED)
    assert edges is not None
    found = CorrectionNetwork.bundled().change(rgb, sparse.depth, completed, edges.probability)
    change = applied_change(found, kept)
    corrected = completed * np.exp(change)
    features, _ = sparse_features(rgb, sparse.depth, corrected, change, edges.probability)
    faded = middles_of_cells(fading(kept))
    true, base = (np.nan_to_num(middles_of_cells(one)) for one in (np.where(kept, np.nan, depth), corrected))
    learnt = (true > 0) & (base > 0) & (faded > 0)
    if learnt.sum() < _LEAST:
        return None
    return Sample(features.astype(np.float16), np.where(learnt, true, np.nan).astype(np.float32), base, faded)


def _taken(path: Path, rng: np.random.Generator) -> tuple[NDArray[np.uint8], Array, Array]:
    """Colour, true and measured depth [m]; exact depth of frames is measured by a simulated camera."""
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return arrays["rgb"], arrays["exact"], arrays["measured"]
    source = load_bench_frame(path)
    depth = source.frame.depth
    return source.frame.rgb, depth, simulated(source.frame, rng) if source.sensor.startswith(RENDERED) else depth


def make_samples(frames: Sequence[Path], out: Path, jobs: int) -> None:
    """Make the samples that a folder lacks, `measured-<frame>-<number>.npz` or `exact-...`, of folders of frames and of
    generated pictures (.npz)."""
    out.mkdir(parents=True, exist_ok=True)
    wanted = [
        (path, number)
        for number in range(FROM_EACH)
        for path in frames
        if number < FROM_PICTURE or path.suffix != ".npz"
    ]
    missing = [one for one in wanted if not _path(out, *one).exists()]
    make = partial(_make_one, out)
    if jobs == 1:
        for one in missing:
            make(one)
        return
    # forked processes would wait for threads that they do not have
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        for done, _ in enumerate(pool.map(make, missing, chunksize=4), 1):
            print(f"\r{done} of {len(missing)} samples", end="" if done < len(missing) else "\n", flush=True)


def _path(out: Path, path: Path, number: int) -> Path:
    return out / f"{_kind(path)}{path.stem}-{number}.npz"


@cache
def _kind(path: Path) -> str:
    exact = path.suffix == ".npz" or load_bench_frame(path).sensor.startswith(RENDERED)
    return EXACT if exact else MEASURED


def _make_one(out: Path, wanted: tuple[Path, int]) -> None:
    cv2.setNumThreads(1)
    made = make_sample(*wanted)
    if made is not None:
        made.save(_path(out, *wanted))


def is_held_out(path: Path) -> bool:
    """Whether a sample's frame is held out."""
    frame = path.stem.partition("-")[2].rpartition("-")[0]
    return zlib.crc32(frame.encode()) % HELD_OUT_SHARE == 0

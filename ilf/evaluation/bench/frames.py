"""Frame folders of the bench, their ground truth, and what is held out of them."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_json
from ...data.arrays import check_shape
from ...data.frame import RGBDFrame
from ...data.pixel_grids import drawn_from
from ...errors import InputError, ParameterError, warn_of_reading
from ...io.frame_additions import is_ground_truth
from ...io.images import read_image
from ...sources.frame_folder import image_at
from ...sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, META_NAME
from ...sources.reading import load_frame
from ..hold_out import HOLD_OUT_PATTERNS, frame_without, generator, hidden_pixels, untrusted_note

GROUND_TRUTH_FILE, HOLE_FILE = "gt.png", "mask.png"


@dataclass(frozen=True, eq=False)
class BenchFrame:
    """A frame and its ground truth.

    Attributes
    ----------
    frame : RGBDFrame
    ground_truth : ndarray of float32, shape (H, W), or None
        Measured or exact depth [m], NaN = unknown; None without ground truth.
    sensor : str
        Sensor that measured it: `sensor` in meta.json, else `source`, else the frame's name. Frames of one sensor
        resemble each other.
    """

    frame: RGBDFrame
    ground_truth: NDArray[np.float32] | None
    sensor: str = ""


def find_frames(paths: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """Return the frame folders among `paths`, and those directly inside other folders, sorted by name.

    Raises
    ------
    InputError
        If a path is not a folder, or has no frame folder in it.
    """
    found: dict[Path, None] = {}
    for path in map(Path, paths):
        if not path.is_dir():
            raise InputError(f"{path} is not a folder. Give folders with {META_NAME}, or folders of such folders.")
        if (path / META_NAME).is_file():
            found[path] = None
            continue
        inside = sorted(entry for entry in path.iterdir() if (entry / META_NAME).is_file())
        if not inside:
            raise InputError(f"{path} has no {META_NAME}, and none of its folders has one. Give folders of frames.")
        found.update(dict.fromkeys(inside))
    return list(found)


def load_bench_frame(folder: str | os.PathLike[str]) -> BenchFrame:
    """Read a frame folder and its ground truth.

    If a folder has gt.png but no depth, the ground truth is used as depth, with the hole that mask.png marks. In both,
    depth that most likely marks missing depth counts as missing.

    Parameters
    ----------
    folder : path-like
        As for `ilf.load_frame`.

    Raises
    ------
    InputError, FormatError
        If the frame cannot be read, has neither depth nor a ground truth with a mask, or their sizes differ.
    """
    root = Path(folder)
    meta = read_json(root / META_NAME)
    if image_at(root, "depth", DEPTH_FILE_SUFFIXES) is None:
        return _masked_ground_truth(root, meta if isinstance(meta, dict) else {"gt": ""})
    frame = load_frame(root)
    # methods use no ground truth, and runs that have one spend time on computing the error; no method gets a guide
    alone = as_measured(frame).with_ground_truth(None).with_guide(None)
    return BenchFrame(alone, frame.ground_truth, _sensor(meta, frame.name))


def as_measured(frame: RGBDFrame) -> RGBDFrame:
    """Return the frame with depth that cannot serve as ground truth (`RGBDFrame.trusted`) marked invalid, and issue a
    `DepthWarning` of it: such depth is neither input nor ground truth of a bench or training."""
    note = untrusted_note(frame)
    if not note:
        return frame
    warn_of_reading(f"{frame.name}: {note}")
    return frame.with_more_invalid(~frame.trusted)


def _masked_ground_truth(root: Path, meta: dict[str, Any]) -> BenchFrame:
    """A frame whose depth is its ground truth outside mask.png."""
    ground_truth, hole_file = root / GROUND_TRUTH_FILE, root / HOLE_FILE
    if not (is_ground_truth(meta.get("gt")) and ground_truth.is_file() and hole_file.is_file()):
        raise InputError(f"{root} has neither raw depth nor a measured or exact {GROUND_TRUTH_FILE} and {HOLE_FILE}.")
    colour = image_at(root, "rgb", COLOUR_SUFFIXES)
    if colour is None:
        raise InputError(f"{root} has no colour image (rgb.png).")
    name = str(meta.get("name") or root.name)
    whole = as_measured(load_frame(colour, ground_truth, depth_units=meta.get("gt_units_per_m"), name=name))
    mask = read_image(hole_file)
    check_shape(str(hole_file), mask.shape[:2], whole.shape)
    hole = mask.reshape(*whole.shape, -1).any(axis=2)
    frame = RGBDFrame(whole.rgb, np.where(hole, np.nan, whole.depth), whole.intrinsics, whole.name)
    return BenchFrame(frame, whole.depth, _sensor(meta, frame.name))


def _sensor(meta: dict[str, Any], name: str) -> str:
    return str(meta.get("sensor") or meta.get("source") or name)


def parse_names(
    names: str, known: Collection[str], groups: Mapping[str, Sequence[str]] | None = None, what: str = "method"
) -> list[str]:
    """Parse a comma-separated list of names; each name is returned once.

    Parameters
    ----------
    names : str
        Names from `known` and `groups`.
    known : collection of str
    groups : mapping, optional
        Name -> members, all of them among `known`.
    what : str
        Kind of the named things, for error messages.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    groups = groups or {}
    allowed = ", ".join([*groups, *known])
    chosen: dict[str, None] = {}
    for name in filter(None, (name.strip() for name in names.split(","))):
        if name not in groups and name not in known:
            raise ParameterError(f"There is no {what} {name!r}. Known: {allowed}.")
        chosen.update(dict.fromkeys(groups.get(name, (name,))))
    if not chosen:
        raise ParameterError(f"The list has no {what}. Known: {allowed}.")
    return list(chosen)


# Hold-out patterns: the same pixels for the same frame name and seed.

POINTS, LINES = 500, 16
"""Number of known pixels that the pattern "points" keeps, and of rows that the pattern "lines" keeps."""

PATTERNS = HOLD_OUT_PATTERNS | {
    "ground-truth": "the frame's own holes, where a measured or exact ground truth exists",
    "points": f"{POINTS} of the known pixels kept",
    "lines": f"{LINES} rows of the frame kept, at equal distances, as of a lidar",
}
"""Name -> description."""


@dataclass(frozen=True, eq=False)
class Task:
    """Input of a method, and the pixels that it is scored on.

    Attributes
    ----------
    frame : RGBDFrame
        Without the held-out depth.
    ground_truth : ndarray of float32, shape (H, W)
        True depth [m].
    scored : ndarray of bool, shape (H, W)
        Pixels that are missing in `frame` and known in `ground_truth`.
    """

    frame: RGBDFrame
    ground_truth: NDArray[np.float32]
    scored: NDArray[np.bool_]


def make_task(source: BenchFrame, pattern: str, seed: int = 0) -> Task:
    """Hold out depth of a frame by a pattern.

    Parameters
    ----------
    source : BenchFrame
    pattern : str
        One of `PATTERNS`.
    seed : int
        Base seed, not negative; the held-out pixels depend on it, the pattern and the frame's name.

    Raises
    ------
    InputError
        If the pattern leaves no pixel to score or no known depth, or does not exist.
    """
    frame = source.frame
    if pattern not in PATTERNS:
        raise InputError(f"There is no pattern {pattern!r}. Known: {', '.join(PATTERNS)}.")
    if pattern == "ground-truth":
        if source.ground_truth is None:
            raise InputError("There is no measured or exact ground truth.")
        task = Task(frame, source.ground_truth, ~frame.known & np.isfinite(source.ground_truth))
    elif pattern in HOLD_OUT_PATTERNS:
        hidden = hidden_pixels(frame, pattern, seed)
        task = Task(frame_without(frame, pattern, seed), frame.depth, hidden & frame.known)
    else:
        rng = generator(frame.name, pattern, seed)
        kept = drawn_from(frame.known, rng, slice(POINTS)) if pattern == "points" else _lines(frame.known)
        if not kept.any():
            raise InputError(f"The pattern {pattern!r} leaves no known depth.")
        depth = np.where(kept, frame.depth, np.float32(np.nan))
        left = RGBDFrame(frame.rgb, depth, frame.intrinsics, frame.name, outside_view=frame.outside_view)
        task = Task(left, frame.depth, frame.known & ~kept)
    if not task.scored.any():
        raise InputError("There is no held-out pixel to score.")
    return task


def _lines(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    rows = ((np.arange(LINES) + 0.5) * len(known) / LINES).astype(int)
    kept = np.zeros_like(known)
    kept[rows] = known[rows]
    return kept

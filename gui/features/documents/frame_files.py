"""Files of frames: what a path is, which files belong together, and how they look before they are opened."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.files import split_dataset
from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError
from ilf.io.depth import read_depth_values
from ilf.io.depth_doubts import PlausibilityWarning
from ilf.io.encodings import encoding_of_inputs
from ilf.io.frame_additions import guide_suffixes
from ilf.io.images import read_colour
from ilf.project.file import open_project
from ilf.project.recorded_frames import measured_frame
from ilf.run.record import read_record
from ilf.sources.frame_folder import frame_folder
from ilf.sources.frame_ref import RECORD_FILE, FrameRef, is_result_folder
from ilf.sources.listing import list_frames
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import recording_suffixes
from ilf.sources.reading import described_beside, read_depth, read_frame

from ...base.paths import PROJECT_SUFFIX, contains_frames

# What a path is, by names only.


class Kind(Enum):
    """What a path is."""

    NOTHING, PAIR, FRAME, FRAMES, PROJECT, RUN = range(6)


def kind_of(path: str) -> Kind:
    """Recognise a path: of a pair of images, the folder of a frame, of frames or a recording, a project, or a run or
    the folder with its result."""
    if not path:
        return Kind.NOTHING
    if Path(path).suffix.lower() == PROJECT_SUFFIX:
        return Kind.PROJECT
    if contains_frames(path):
        return Kind.FRAMES
    if Path(path).is_dir():
        return Kind.RUN if is_result_folder(FrameRef(path)) else Kind.FRAME
    return Kind.RUN if Path(path).suffix.lower() == ".json" else Kind.PAIR


# Filters of file dialogs, and pairs of files by their usual names.

_COLOUR_WORDS = ("rgb", "colour", "color", "image")
_DEPTH_WORDS = ("depth",)


def files_of(kind: str, suffixes: Iterable[str], *others: str) -> str:
    """Return the filters of file dialogs for files with these suffixes, others, and all files."""
    return ";;".join((f"{kind} ({' '.join(f'*{suffix}' for suffix in suffixes)})", *others, "All files (*)"))


def guide_files() -> str:
    """Return the filter of file dialogs for guides."""
    return files_of("Guides", guide_suffixes())


def recording_files() -> str:
    """Return the filter of file dialogs for recordings."""
    return f"Recordings ({' '.join(f'*{suffix}' for suffix in recording_suffixes())})"


def pair_of(path: Path) -> tuple[Path, Path] | None:
    """Return the colour and the depth file of which one is `path`, and the other lies beside it; None if none does."""
    colour = _partner(path, _DEPTH_WORDS, _COLOUR_WORDS, COLOUR_SUFFIXES) if looks_like_depth(path) else None
    depth = path if colour is not None else _partner(path, _COLOUR_WORDS, _DEPTH_WORDS, DEPTH_FILE_SUFFIXES)
    return None if depth is None else (colour or path, depth)


def looks_like_depth(path: Path) -> bool:
    """Return whether a file is depth by its name."""
    return "depth" in path.stem.lower() or path.suffix.lower() in set(DEPTH_FILE_SUFFIXES) - set(COLOUR_SUFFIXES)


def _partner(
    path: Path, own_words: tuple[str, ...], other_words: tuple[str, ...], suffixes: tuple[str, ...]
) -> Path | None:
    """Return the file beside another that has its name with the other words, or in the folder with their name."""
    own = re.compile("|".join(own_words), re.IGNORECASE)
    bare = re.sub(rf"[-_.]?({own.pattern})$", "", path.stem, flags=re.IGNORECASE)
    stems = [own.sub(word, path.stem) for word in other_words if own.search(path.stem)]
    stems += [f"{bare}_{word}" for word in other_words] + [path.stem, bare, *other_words]
    folders = [path.parent]
    if own.fullmatch(path.parent.name):
        folders += [path.parent.with_name(word) for word in other_words]
    for folder in folders:
        for stem in filter(None, stems):
            for suffix in suffixes:
                candidate = folder / (stem + suffix)
                if candidate != path and candidate.is_file():
                    return candidate
    return None


# How a path looks before it is opened.

_MAX_NAMED = 5


@dataclass(frozen=True, eq=False)
class Look:
    """What is seen of a path before it is opened.

    Attributes
    ----------
    text, tone : str
        What it is, or why it cannot be opened, and the tone of this message.
    colour, depth : array or None
        Of the frame, or the first one, in any unit.
    doubts : tuple of PlausibilityWarning
        Plausibility warnings about the way its depth is read.
    can_be_opened : bool
    found : object
        What is taken then, if it is not opened by its path.
    """

    text: str
    tone: str = "text"
    colour: NDArray[np.uint8] | None = None
    depth: NDArray[Any] | None = None
    doubts: tuple[PlausibilityWarning, ...] = ()
    can_be_opened: bool = True
    found: Any = None


def look_at_frame(source: FrameRef) -> Look:
    """Read a frame and describe it; raises what `read_frame` does."""
    frame = read_frame(source)
    return _look_of(frame, source, " ".join(filter(None, (_describe_frame(frame), described_beside(source)))))


def look_into(how: FrameRef) -> Look:
    """List the frames of the folder or recording `how.rgb` and read the first; raises what `list_frames` does."""
    listing = list_frames(how.rgb, how.options)
    first = listing.sources[0]
    frames = f"{counted(len(listing.sources), 'result' if is_result_folder(first) else 'frame')} found."
    text = " ".join((frames, *listing.notes))
    try:
        frame = measured_frame(first)
        return _look_of(frame, first, f"{text} First frame:\n{_describe_frame(frame)}")
    except IlfError as error:
        return Look(f"{text}\nThe first frame cannot be read: {error}", "warning")


def _look_of(frame: RGBDFrame, source: FrameRef, text: str) -> Look:
    doubts = read_depth(source).plausibility_warnings if frame.notes and not is_result_folder(source) else ()
    tone = "warning" if frame.notes else "text" if frame.intrinsics is None else "good"
    return Look("\n".join((text, *frame.notes)), tone, frame.rgb, frame.depth, doubts)


def look_at_file(path: Path) -> Look:
    """Describe a project or the record of a run."""
    if kind_of(str(path)) is Kind.RUN:
        record = read_record(path / RECORD_FILE if path.is_dir() else path)
        text = f"A run of {record.name} with {counted(len(record.blocks_outcome), 'block')}: the frame that was "
        return Look(f"{text}completed is opened, with blocks, parameters and result.", "good")
    with open_project(path) as opened:
        names = [frame.name for frame in opened.project.frames]
    shown = ", ".join(names[:_MAX_NAMED]) + ", …" * (len(names) > _MAX_NAMED)
    text = f"A project with {counted(len(names), 'frame')}: {shown}.\nIt takes the place of the present one."
    return Look(text, "good")


def refused(text: str, tone: str, colour: str, depth: str, request: Callable[[], FrameRef]) -> Look:
    """Say why a frame cannot be opened, with what can be seen of its files; with what its depth makes doubtful in the
    tone of an error."""
    doubts = _try_read(lambda: read_depth(request()).plausibility_warnings) or () if tone == "error" else ()
    if colour and Path(colour).is_dir():
        found = _try_read(lambda: frame_folder(colour))
        colour, depth = (str(found.rgb), str(found.depth)) if found else ("", "")
    depth, dataset = split_dataset(depth)
    return Look(
        text,
        tone,
        _try_read(lambda: read_colour(colour)) if colour else None,
        _try_read(lambda: read_depth_values(depth, dataset=dataset)) if depth else None,
        doubts,
        can_be_opened=False,
    )


_Result = TypeVar("_Result")


def _describe_frame(frame: RGBDFrame) -> str:
    """Describe a frame: depth, size and encoding in the first line, then guide and intrinsics."""
    known = frame.depth[frame.known]
    height, width = frame.shape
    encoding = "" if frame.inputs is None else encoding_of_inputs(frame.inputs).text
    outside = f", {100 * frame.outside_share:.0f} % outside the depth camera's view" if frame.outside_share else ""
    first = (
        f"Median {np.median(known):.2f} m, range {known.min():.2f}–{known.max():.2f} m, {width} x {height}, "
        f"{100 * frame.missing_share:.1f} % missing{outside}, {encoding}."
    )
    if frame.brought is not None:
        seen = 100 * frame.brought.seen.mean()
        first += f"\nIn the depth camera's view: colour was brought into it, and sees {seen:.0f} % of the pixels."
    if frame.guide is not None:
        covered = np.isfinite(frame.guide.values[~frame.known])
        first += f"\nThe guide covers {100 * covered.mean() if covered.size else 100:.0f} % of the missing pixels."
    if frame.intrinsics is None:
        return f"{first}\nNo intrinsics: a point cloud is not possible."
    camera = frame.intrinsics
    return f"{first}\nIntrinsics: fx {camera.fx:g}, fy {camera.fy:g}, cx {camera.cx:g}, cy {camera.cy:g} px."


def _try_read(read: Callable[[], _Result]) -> _Result | None:
    """Return what can be read for a preview, else None; the message contains the error already."""
    try:
        return read()
    except IlfError:
        return None

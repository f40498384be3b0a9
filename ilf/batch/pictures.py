"""Previews of a batch's frames, with the same colour range for all frames."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont, ImageOps

from .._runtime.children import run_in_processes
from .._runtime.installation import optional
from .._runtime.writing import atomic_path, write_bytes
from ..data.pictures import depth_colours
from ..data.results import Completion
from ..drawing.colours import robust_depth_levels, sample, to_indices
from ..errors import FormatError, InputError, told_as
from ..io.images import read_colour
from ..sources.frame_ref import FrameRef
from ..sources.reading import read_frame
from .frame_record import FrameOutcome
from .frames import BatchFrame
from .settings import Levels

PREVIEW_FILE = "preview.png"

_WIDTH = 320
"""Maximum width of each of the three pictures in a preview [px]."""

_SAMPLED_FRAMES = 16
"""Number of frames of a batch that the colour range is computed from."""


def depth_levels(frames: Sequence[BatchFrame]) -> Levels:
    """Compute the colour range, depth [m] of its two ends, from a sample of the frames at equal distances.

    The same frames give the same range; unreadable frames are ignored.
    """
    chosen = np.unique(np.linspace(0, len(frames) - 1, _SAMPLED_FRAMES).round().astype(int))
    sources = [frames[number].source for number in chosen.tolist()]
    found = [part for _, part in run_in_processes(_some_depth, sources) if part is not None]
    return robust_depth_levels(np.concatenate(found)) if found else (0.0, 1.0)


def _some_depth(source: FrameRef) -> NDArray[np.floating] | None:
    """Return the depth [m] of a frame at evenly spaced pixels; None if it cannot be read."""
    try:
        return sample(read_frame(source).depth)
    except Exception:  # told when the frame is completed
        return None


def write_preview(folder: Path, completion: Completion, levels: Levels) -> str:
    """Write colour, measured and completed depth side by side into a frame's folder; return the file's name.

    Parameters
    ----------
    folder : Path
    completion : Completion
    levels : tuple of float
        Colour range: depth [m] of its two ends.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    table, frame = depth_colours(), completion.frame
    pictures = [frame.rgb, *(table[to_indices(values, *levels)] for values in (frame.measured, completion.depth))]
    height, width = frame.shape
    size = min(width, _WIDTH), max(round(height * min(width, _WIDTH) / width), 1)
    small = [cv2.resize(picture, size, interpolation=cv2.INTER_AREA) for picture in pictures]
    _, encoded = cv2.imencode(".png", np.hstack(small)[..., ::-1])
    write_bytes(folder / PREVIEW_FILE, encoded.tobytes())
    return PREVIEW_FILE


def read_preview(folder: Path) -> NDArray[np.uint8]:
    """Read the preview in a frame's folder, uint8 (H, W, 3), red first; raises FormatError if it cannot be read."""
    with told_as(FormatError, "{error} Otherwise complete the frame again.", InputError):
        return read_colour(folder / PREVIEW_FILE)


# Contact sheet and video of the previews of a batch.

SHEET_FILE, VIDEO_FILE = "contact-sheet.png", "video.mp4"

_COLUMNS, _MAX_PICTURES = 4, 160
_CELL, _CAPTION, _GAP = (384, 96), 16, 8
"""Layout of the contact sheet: columns, maximum number of pictures, and sizes [px]."""

_PAPER, _INK, _WARNING = (255, 255, 255), (40, 44, 52), (186, 32, 42)

_DEFAULT_RATE = 10.0
"""Frame rate of a video of frames without timestamps [1/s]."""

_RATES = (1.0, 60.0)


def write_contact_sheet(folder: Path, outcomes: Sequence[FrameOutcome]) -> Path:
    """Write one picture of all previews with the names of their frames; of many frames, an even selection.

    Parameters
    ----------
    folder : Path
        Of the batch's results.
    outcomes : sequence of FrameOutcome
        In the order of the pictures; failed frames are shown by name only.

    Raises
    ------
    InputError
        If there are none.
    ExportError
        If it cannot be written.
    """
    if not outcomes:
        raise InputError(f"{folder} has no frames for a contact sheet.")
    places = np.unique(np.linspace(0, len(outcomes) - 1, _MAX_PICTURES).round().astype(int))
    chosen = [outcomes[place] for place in places.tolist()]
    columns = min(_COLUMNS, len(chosen))
    rows = -(-len(chosen) // columns)
    width, height = _CELL[0] + _GAP, _CELL[1] + _CAPTION + _GAP
    sheet = Image.new("RGB", (columns * width + _GAP, rows * height + _GAP), _PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(11)
    for number, outcome in enumerate(chosen):
        row, column = divmod(number, columns)
        left, top = _GAP + column * width, _GAP + row * height
        if outcome.is_completed:
            sheet.paste(_fitted(read_preview(folder / outcome.folder), _CELL), (left, top))
        draw.text((left, top + _CELL[1] + 1), _caption(outcome), _INK if outcome.is_completed else _WARNING, font)
    path = folder / SHEET_FILE
    with atomic_path(path) as temporary:
        sheet.save(temporary)
    return path


def write_video(folder: Path, outcomes: Sequence[FrameOutcome]) -> Path:
    """Write the previews of a batch's completed frames as a video at the frame rate of the recording.

    Parameters
    ----------
    folder : Path
        Of the batch's results.
    outcomes : sequence of FrameOutcome
        In the order of the pictures; failed frames are left out.

    Raises
    ------
    InputError
        If there are none, or PyAV is not installed (extra `sensors`).
    ExportError
        If it cannot be written.
    """
    av = optional("av", "ilf-studio[sensors]", "A video")
    shown = [outcome for outcome in outcomes if outcome.is_completed]
    if not shown:
        raise InputError(f"{folder} has no completed frames for a video.")
    height, width, _ = read_preview(folder / shown[0].folder).shape
    size = width - width % 2, height - height % 2  # the codec requires even sizes
    path = folder / VIDEO_FILE
    with atomic_path(path) as temporary, av.open(str(temporary), "w") as video:
        stream = video.add_stream("libx264", rate=Fraction(_rate(shown)).limit_denominator(1000))
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for outcome in shown:
            picture = np.asarray(_fitted(read_preview(folder / outcome.folder), size))
            video.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        video.mux(stream.encode())
    return path


def _rate(outcomes: Sequence[FrameOutcome]) -> float:
    times = [outcome.time_s for outcome in outcomes if outcome.time_s is not None]
    if len(times) < max(len(outcomes), 2):
        return _DEFAULT_RATE
    step = float(np.median(np.diff(times)))
    return float(np.clip(1 / step, *_RATES)) if step > 0 else _DEFAULT_RATE


def _fitted(picture: NDArray[np.uint8], size: tuple[int, int]) -> Image.Image:
    """Scale a picture to fit this width and height, and centre it."""
    return ImageOps.pad(Image.fromarray(picture), size, Image.Resampling.BOX, _PAPER)


def _caption(outcome: FrameOutcome) -> str:
    name = outcome.frame if len(outcome.frame) <= 48 else f"…{outcome.frame[-47:]}"
    return name if outcome.is_completed else f"{name}: failed"

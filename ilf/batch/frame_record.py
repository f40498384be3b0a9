"""frame.json: the result of a frame of a batch. It is written last and lists the output files beside it."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from .._runtime.files import file_sha256, is_address, read_json
from .._runtime.schema import check_schema, converted, json_file
from .._runtime.writing import write_bytes
from ..data.frame import RGBDFrame
from ..errors import FormatError, IlfError, InputError
from ..run.record import array_sha256
from ..sources import reading
from ..sources.frame_ref import OPTIONS, RECORD_FILE
from ..sources.named_places import may_look_at
from ..sources.naming import META_NAME
from ..sources.neighbours import read_or_none, with_neighbours
from .frames import BatchFrame
from .settings import SCHEMA, sha256_of

# The input of a frame of a batch: options, files and their content.


@dataclass(frozen=True, eq=False)
class LoadedFrame:
    """A loaded frame and its neighbours.

    Attributes
    ----------
    frame : RGBDFrame
        With the depth of its neighbours, unless they are those of a static camera.
    neighbours : tuple of RGBDFrame
        The readable neighbours of a static camera; else empty.
    content : str
        SHA-256 over the content of all files and how they were read.
    files : dict
        Path of every file -> size and modification time [ns]; as long as both are unchanged, the content is assumed
        unchanged.
    """

    frame: RGBDFrame
    neighbours: tuple[RGBDFrame, ...]
    content: str
    files: dict[str, list[int]]


def read_frame(frame: BatchFrame) -> LoadedFrame:
    """Read a frame and its neighbours; raises as `ilf.sources.reading.read_frame` for the frame itself."""
    before = source_files(frame)  # stamps from before reading, so that changes meanwhile are noticed
    read = reading.read_frame(frame.source)
    if frame.neighbour_step:
        read = with_neighbours(read, frame.before, frame.after, step=frame.neighbour_step)
        return LoadedFrame(read, (), _content_of([read]), {**file_stamps(read.files), **before})
    neighbours = [read_or_none(source) for source in frame.neighbours]
    there = [neighbour for neighbour in neighbours if neighbour is not None]
    files = {**file_stamps(path for one in (read, *there) for path in one.files), **before}
    return LoadedFrame(read, tuple(there), _content_of([read, *neighbours]), files)


def current_content(frame: BatchFrame) -> str | None:
    """Return the present `LoadedFrame.content`; None if the frame cannot be read."""
    try:
        return read_frame(frame).content
    except IlfError:
        return None


def reading_sha256(frame: BatchFrame) -> str:
    """Return the SHA-256 of the options that a frame is read with: all of its sources but paths, which may change when
    a data set is moved."""
    return sha256_of(
        [
            [source.frame, sorted(item for item in source.options.to_json().items() if not OPTIONS[item[0]].is_path)]
            for source in (frame.source, *frame.neighbours)
        ]
    )


def source_files(frame: BatchFrame) -> dict[str, list[int]]:
    """Return the files of a frame's sources, as in `LoadedFrame.files`; raises as `FrameRef.allowed`."""
    paths: list[str] = []
    for source in (one.allowed() for one in (frame.source, *frame.neighbours)):
        paths += source.paths
        if source.depth is None:
            paths.append(os.path.join(source.rgb, META_NAME))
    return file_stamps(paths)


def file_stamps(paths: Iterable[str]) -> dict[str, list[int]]:
    """Return path -> size and modification time [ns] of the existing files."""
    found = {}
    for path in paths:
        try:
            state = os.stat(path)
        except (OSError, ValueError):  # missing, or not a valid path
            continue
        found[path] = [state.st_size, state.st_mtime_ns]
    return found


def _content_of(frames: Sequence[RGBDFrame | None]) -> str:
    return sha256_of([None if frame is None else _facts(frame) for frame in frames])


def _facts(frame: RGBDFrame) -> list[Any]:
    inputs, guide = frame.inputs, frame.guide
    facts: list[Any] = [None if guide is None else (array_sha256(guide.array), guide.gives), repr(frame.intrinsics)]
    if inputs is not None:
        files = inputs.rgb, inputs.depth, inputs.ground_truth
        facts += [None if file is None else file.sha256 for file in files]
        facts += [inputs.depth_units, inputs.encoding, inputs.invalid]
        lenses = (lens.to_json() for lens in inputs.lenses or ())
        facts += filter(None, (inputs.depth_intrinsics, inputs.dataset, *lenses, inputs.view, inputs.depth_to_colour))
    if frame.neighbours is not None:
        facts += [one.sha256 for one in frame.neighbours.neighbours]
    return facts


FRAME_FILE = "frame.json"


@dataclass(frozen=True)
class FrameOutcome:
    """The result of a frame of a batch in numbers; None for values that do not exist.

    Attributes
    ----------
    frame : str
        Key of the frame.
    folder : str
        Name of the folder with its results.
    time_s : float or None
        Timestamp [s].
    status : "completed" or "failed"
    message : str
        Why it failed, or notes on the result.
    seconds : float or None
        Duration [s].
    blocks : int or None
    pixels : int or None
        Number of pixels of the frame.
    missing_before, missing_after : int or None
        Pixels without depth in the frame and in its completion, without those outside the view.
    outside_view : int or None
        Pixels that the depth camera could not see.
    expected_error_median_m, expected_error_p90_m : float or None
        Median and 90th percentile of the expected error [m] over the pixels filled by blocks: `median` and `p90` of
        `ilf.completion.confidence.expected_error.error_summary`.
    hold_out_mae_m, hold_out_rmse_m : float or None
        Errors [m] on hold-out, if the batch evaluates it.
    truth_mae_m, truth_rmse_m : float or None
        Errors [m] of the filled depth against the frame's ground truth, if it has one.
    plausibility_warnings : str
        Plausibility warnings of its files; "" if there are none.
    """

    frame: str
    folder: str
    time_s: float | None
    status: Literal["completed", "failed"]
    message: str = ""
    seconds: float | None = None
    blocks: int | None = None
    pixels: int | None = None
    missing_before: int | None = None
    missing_after: int | None = None
    outside_view: int | None = None
    expected_error_median_m: float | None = None
    expected_error_p90_m: float | None = None
    hold_out_mae_m: float | None = None
    hold_out_rmse_m: float | None = None
    truth_mae_m: float | None = None
    truth_rmse_m: float | None = None
    plausibility_warnings: str = ""

    @property
    def is_completed(self) -> bool:
        """Whether the frame was completed; otherwise it failed."""
        return self.status == "completed"


@dataclass(frozen=True)
class FrameRecord:
    """An outcome with hashes of its inputs and the list of its output files.

    Attributes
    ----------
    outcome : FrameOutcome
    settings : str
        `sha256_of` the settings' facts.
    reading : str
        `reading_sha256` the frame.
    content : str or None
        `LoadedFrame.content`; None if the frame failed.
    files : dict
        `LoadedFrame.files`.
    run : str or None
        SHA-256 of its run.json.
    outputs : tuple of str
        Names of all its output files.
    """

    outcome: FrameOutcome
    settings: str
    reading: str
    content: str | None = None
    files: dict[str, list[int]] = field(default_factory=dict)
    run: str | None = None
    outputs: tuple[str, ...] = ()

    def has_all_files(self, folder: Path) -> bool:
        """Return whether all its output files exist and belong together."""
        there = all(os.path.exists(folder / name) for name in self.outputs)
        if not self.outcome.is_completed or not there:
            return False
        return self.run is None or file_sha256(folder / RECORD_FILE) == self.run

    def is_of(self, frame: BatchFrame) -> bool | None:
        """Return whether a frame is read with the same options from unchanged files; None if the files' stamps differ,
        so that their `current_content` must be compared."""
        if self.reading != reading_sha256(frame):
            return False
        has_stamps = not any(map(is_address, frame.source.paths)) and all(map(may_look_at, self.files))
        return True if has_stamps and self.files == file_stamps(self.files) else None


def read_frame_record(folder: Path) -> FrameRecord | None:
    """Read the record in a frame's folder; None if there is none or it is damaged, so that the frame is completed
    again. Raises InputError if it cannot be read for another reason."""
    try:
        values = read_json(folder / FRAME_FILE)
        check_schema(values, SCHEMA, "frame record")
        return converted(values, FrameRecord, "frame record")
    except (FormatError, AttributeError):
        return None
    except InputError:
        if os.path.lexists(folder / FRAME_FILE):
            raise
        return None


def write_frame_record(folder: Path, record: FrameRecord) -> None:
    """Write a record into the frame's folder, which is created if missing; raises ExportError as `write_bytes`."""
    write_bytes(folder / FRAME_FILE, json_file(SCHEMA, dataclasses.asdict(record)))

"""Export of many frames: each into a folder of its own; what has not changed since an earlier export is skipped."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

from .._runtime.long_work import check_cancelled
from .._runtime.writing import check_writable
from ..data.blocks import labels_in
from ..data.parameters import Parameters
from ..data.results import Completion, compose
from ..errors import Cancelled, IlfError
from ..run.formats import BLOCKS, FORMATS
from ..run.options import ExportOptions, as_file_name
from ..run.record import RecordedNetworks, RunRecord, array_sha256, make_record, read_record
from ..run.replaying import file_problems, network_differences
from ..run.run import Run
from ..run.writing import check_write, colour_path, drop_impossible, write
from ..sources.frame_ref import RECORD_FILE
from .frame_state import FrameState


class ExportStatus(StrEnum):
    """What became of a frame."""

    WRITTEN = "written"
    UNCHANGED = "unchanged"
    FAILED = "failed"


@dataclass(frozen=True)
class ExportedFrame:
    """The export of one frame.

    Attributes
    ----------
    name : str
        Name of the frame.
    folder : Path
    status : ExportStatus
        Unchanged: its files are those that an export would write.
    notes : tuple of str
        Notes on the files; the reason if it has failed.
    """

    name: str
    folder: Path
    status: ExportStatus
    notes: tuple[str, ...] = ()


Read = Callable[[], tuple[Run, Completion | None]]


@dataclass(frozen=True, eq=False)
class FrameToExport:
    """A frame to export.

    Attributes
    ----------
    name : str
    folder : str
        Name of its folder.
    read : callable
        Reads the frame: its run, and its completion if it is already known.
    """

    name: str
    folder: str
    read: Read


def run_and_completion(state: FrameState) -> tuple[Run, Completion | None]:
    """Return a frame's present results as a run and its completion; the run of all blocks, and None, if a block has no
    result."""
    run = state.run()
    labels = _labels(run)
    if not labels or labels - state.results.keys():
        return run, None
    return state.present_run(), state.present_completion()


def _labels(run: Run) -> frozenset[int]:
    """The blocks that a run completes."""
    return labels_in(run.blocks.labels) if run.only is None else frozenset(run.only)


def export_frames(
    frames: Sequence[FrameToExport], folder: Path, options: ExportOptions, *, strict: bool = False
) -> Iterator[ExportedFrame]:
    """Export frames, each into its folder in `folder`; frames whose completion is not known are completed first.

    An error of a frame becomes its status, and the others go on. A frame is skipped if its folder has a run record of
    the same run with complete files, so that an export that was interrupted goes on where it stopped.

    Parameters
    ----------
    frames : sequence of FrameToExport
    folder : Path
    options : ExportOptions
    strict : bool
        Whether a frame without intrinsics fails if a cloud is selected; otherwise it is exported without.

    Raises
    ------
    ExportError
        If nothing can be written into the folder.
    """
    check_writable(folder)
    for frame in frames:
        check_cancelled()
        target = folder / frame.folder
        try:
            yield _exported(frame, target, options, strict)
        except Cancelled:
            raise
        except (IlfError, OSError, MemoryError) as error:
            reason = str(error) or type(error).__name__
            yield ExportedFrame(frame.name, target, ExportStatus.FAILED, (reason,))


def _exported(frame: FrameToExport, target: Path, options: ExportOptions, strict: bool) -> ExportedFrame:
    run, completion = frame.read()
    possible, without = (options, ()) if strict else drop_impossible(options, run)
    check_write(target, run, possible)
    if _is_unchanged(target, run, completion, possible):
        return ExportedFrame(frame.name, target, ExportStatus.UNCHANGED)
    found = run.complete() if completion is None else replace(completion, run=run)
    written = write(target, found, possible)
    notes = *without, *found.notes, *written.notes
    return ExportedFrame(frame.name, target, ExportStatus.WRITTEN, tuple(dict.fromkeys(notes)))


def _is_unchanged(target: Path, run: Run, completion: Completion | None, options: ExportOptions) -> bool:
    """Whether the folder has the files of this run: the same inputs, blocks, parameters and networks, and depth if it
    is known."""
    try:
        record = read_record(target / RECORD_FILE)
    except IlfError:  # there is none, or none of this version
        return False
    wanted = {label: run.parameters_of(label) for label in _labels(run)}
    same_run = _inputs_of(record) == _inputs_of(make_record(compose(run, {}), options))
    same_depth = completion is None or record.depth_sha256 == array_sha256(completion.depth)
    if not (options.run_record and same_run and record.own_parameters == wanted and same_depth):
        return False
    if file_problems(record, target) or network_differences(record):
        return False
    # names and colours of blocks are in no record
    named = [FORMATS[name] for name in options.exports if FORMATS[name].group == BLOCKS]
    nothing, image = compose(run, {}), colour_path(target, run, options)
    return all((target / one.file).read_bytes() == one.content(nothing, image)[0] for one in named)


def _inputs_of(record: RunRecord) -> RunRecord:
    """A record without results, and without parameters, which depend on the blocks that were run."""
    return replace(
        record,
        networks=RecordedNetworks({}, {}),
        parameters=Parameters(),
        block_parameters={},
        blocks_outcome=(),
        depth_sha256="",
        outputs={},
    )


def in_folders(frames: Iterable[tuple[str, str, Read]]) -> list[FrameToExport]:
    """Return frames, given by name, id and what reads them, each with a folder that no other one has, ignoring case."""
    taken: set[str] = set()
    named = []
    for name, frame_id, read in frames:
        plain = as_file_name(name)
        folder = f"{plain}-{frame_id}" if plain.casefold() in taken else plain
        taken.add(folder.casefold())
        named.append(FrameToExport(name, folder, read))
    return named

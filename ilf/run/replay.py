"""From a run record back to what the run needs: the same frame, blocks, parameters and files."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..ebs import extract
from ..errors import InputError
from ..frame import RGBDFrame
from ..io import load_frame, read_labels
from ..parameters import BlockParameters, Parameters
from .export import LABELS_FILE, ExportOptions
from .record import RecordedFile, RecordedInputs, RunRecord, file_sha256, labels_sha256, library_versions


@dataclass(frozen=True, eq=False)
class Replay:
    """What it takes to make a recorded run again.

    Attributes
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
    parameters : dict
        Label -> parameters, for just those blocks that were run.
    options : ExportOptions
    extraction : BlockParameters or None
    edited : bool
    inputs : RecordedInputs
        As recorded, wherever the files are now; with them the new record is the same as the old one.
    warnings : tuple of str
    """

    frame: RGBDFrame
    labels: NDArray[np.int32]
    parameters: dict[int, Parameters]
    options: ExportOptions
    extraction: BlockParameters | None
    edited: bool
    inputs: RecordedInputs
    warnings: tuple[str, ...]


def replay(
    record: RunRecord,
    folder: str | os.PathLike[str],
    rgb: str | os.PathLike[str] | None = None,
    depth: str | os.PathLike[str] | None = None,
) -> Replay:
    """Load and check everything that a recorded run was made of.

    Parameters
    ----------
    record : RunRecord
    folder : path-like
        Where the record lies. The label map is looked for in it, and input files that are no longer where
        they were.
    rgb, depth : path-like, optional
        Where the input files are now.

    Raises
    ------
    InputError
        If an input file is missing or is not the recorded one, or the blocks cannot be had again.
    """
    if record.inputs is None:
        raise InputError("This run cannot be replayed: its frame was not read from files, so there is nothing to load.")
    inputs, beside = record.inputs, Path(folder)
    frame = load_frame(
        _recorded_file(inputs.rgb, "colour file", beside, rgb),
        _recorded_file(inputs.depth, "depth file", beside, depth),
        depth_units=inputs.depth_units,
        intrinsics=inputs.intrinsics,
    )
    labels, warnings = _labels(record, frame, beside)
    gone = sorted(set(record.parameters) - set(np.unique(labels).tolist()))
    if gone:
        raise InputError(f"The record has outcomes of blocks that its label map lacks: {gone}. It has been changed.")
    return Replay(frame, labels, record.parameters, record.options, record.extraction, record.edited, inputs, warnings)


def version_differences(record: RunRecord) -> str:
    """The program and libraries whose versions are not those of the record, in words; "" if all are the same."""
    recorded = {"ilf": record.version, **record.versions}
    present = {"ilf": __version__, **library_versions()}
    return ", ".join(
        f"{name} {version} (here {present.get(name)})"
        for name, version in recorded.items()
        if version != present.get(name)
    )


def _recorded_file(recorded: RecordedFile, what: str, folder: Path, given: str | os.PathLike[str] | None) -> Path:
    """The file with the recorded content: the given one, or where it was, or beside the record."""
    name = re.split(r"[\\/]", recorded.path)[-1]
    candidates = [Path(given)] if given is not None else [Path(recorded.path), folder / name]
    present = [path for path in candidates if path.is_file()]
    for path in present:
        if file_sha256(path) == recorded.sha256:
            return path
    if not present:
        raise InputError(
            f"{candidates[0]}: there is no such file, but it is the {what} of the recorded run. "
            "Give the colour and the depth file to say where they are now."
        )
    raise InputError(
        f"{present[0]} is not the {what} of the recorded run: its content has changed. Restore it, or give the "
        "colour and the depth file that were used."
    )


def _labels(record: RunRecord, frame: RGBDFrame, folder: Path) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """The recorded label map and warnings: extracted again, or read from the file beside the record."""
    extracted = record.extraction is not None and not record.edited
    if extracted:
        again = extract(frame, record.extraction)
        notes = again.notes
        if labels_sha256(again.blocks) == record.labels_sha256:
            return again.blocks, notes
    saved = _saved_labels(record, folder)
    name = record.labels_file or LABELS_FILE
    if not extracted:
        if saved is None:
            raise InputError(
                f"The blocks of this run were drawn or edited by hand, and their label map ({name}) is not beside the "
                "record, or has changed. Put it there."
            )
        return saved, ()
    versions = version_differences(record)
    problem = "The extraction gives other blocks than recorded"
    if versions:
        problem += f" by {versions}"
    if saved is None:
        raise InputError(
            " ".join((*notes, f"{problem}. Install the recorded versions, or put the run's {name} beside the record."))
        )
    return saved, (*notes, f"{problem}; those of {name} are used.")


def _saved_labels(record: RunRecord, folder: Path) -> NDArray[np.int32] | None:
    """The label map beside the record; None if it is missing or not the recorded one."""
    if record.labels_file is None or not (folder / record.labels_file).is_file():
        return None
    labels = read_labels(folder / record.labels_file)
    matches = labels.shape == record.shape and labels_sha256(labels) == record.labels_sha256
    return labels if matches else None

"""Facts about the frames of a project, without opening them."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from ..data.frame import InputFile
from ..data.results import Completion
from ..errors import InputError
from ..run.record import array_sha256
from ..run.replaying import depth_difference_text
from .archive import Parts
from .codec import UNREADABLE, check_content, from_plain, stored_fields
from .file import OpenedProject
from .frame_state import FrameState
from .project import ProjectFrame
from .run_history import StoredRun
from .sources import embedded, located
from .state_codec import frame_part, read_head

_OF_RUN = (
    "number", "name", "how", "done", "seconds", "note", "ground_truth_error", "hold_out_error", "expected_error",
)  # fmt: skip


@dataclass(frozen=True)
class FrameFacts:
    """Facts about a frame in a project.

    Attributes
    ----------
    frame : ProjectFrame
    sources : dict of str to str
        Path of each of its files -> "embedded", "present", "changed", "missing", or "not allowed" if it may lie where
        nothing is opened unasked.
    runs : tuple of dict of str to object
        Number, name, how, done, seconds, note and errors of each run of the history, as in `StoredRun`.
    size : int
        Bytes of its own part and of the arrays that it refers to.
    problems : tuple of str
        Why the work on it cannot be read.
    """

    frame: ProjectFrame
    sources: dict[str, str]
    runs: tuple[dict[str, Any], ...] = ()
    size: int = 0
    problems: tuple[str, ...] = ()


def frame_facts(opened: OpenedProject, frame: ProjectFrame) -> FrameFacts:
    """Collect the facts about a frame; reads all its parts and files, and checks their hashes.

    Parameters
    ----------
    opened : OpenedProject
    frame : ProjectFrame
    """
    sources = {file.path: _how_found(file, opened) for file in _wanted_files(frame, opened.parts)}
    if not frame.has_state:
        return FrameFacts(frame, sources)
    try:
        content = opened.parts.read(frame_part(frame.id))
        head = read_head(content)
        kinds = stored_fields(StoredRun)
        runs = tuple({name: from_plain(run[name], kinds[name], {}) for name in _OF_RUN} for run in head.state["runs"])
        size = len(content)
        for name in head.parts:
            part = opened.parts.read(name)
            check_content(name, part)
            size += len(part)
    except UNREADABLE as error:
        return FrameFacts(frame, sources, problems=(f"The work on this frame cannot be read: {error}",))
    return FrameFacts(frame, sources, runs, size)


def _how_found(wanted: InputFile, opened: OpenedProject) -> str:
    """Return how a file is there, as in `FrameFacts.sources`."""
    if embedded(wanted, opened.parts) is not None:
        return "embedded"
    same, other = located(wanted, opened.places)
    if same is not None or other is not None:
        return "changed" if same is None else "present"
    try:
        opened.places.check(wanted)
    except InputError:
        return "not allowed"
    return "missing"


def _wanted_files(frame: ProjectFrame, parts: Parts) -> list[InputFile]:
    """List the files of a frame from its state, or else from its source, without their SHA-256."""
    if frame.has_state:
        with suppress(*UNREADABLE):  # else from the source
            return list(read_head(parts.read(frame_part(frame.id))).files)
    return [] if frame.source is None else [InputFile(path, "") for path in frame.source.paths]


def differences(state: FrameState, completion: Completion) -> tuple[str, ...]:
    """Compare a new completion with the stored results; empty if they are identical bit for bit.

    Parameters
    ----------
    state : FrameState
    completion : Completion
        Of `state.present_run()`.

    Returns
    -------
    tuple of str
        The differences, one sentence each.

    Examples
    --------
    >>> import ilf
    >>> import numpy as np
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> completion = ilf.complete(ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth))
    >>> from ilf.data.blocks import Blocks
    >>> state = FrameState("a1", completion.frame, Blocks(completion.blocks), results=completion.results)
    >>> differences(state, completion)
    ()
    """
    stored = state.present_completion()
    sentences = []
    if array_sha256(stored.depth) != array_sha256(completion.depth):
        sentences.append(f"{depth_difference_text(completion.depth, stored.depth)}.")
    others = [label for label, outcome in stored.outcomes.items() if completion.outcomes.get(label) != outcome]
    if others:
        blocks = ", ".join(map(str, others[:10])) + (", ..." if len(others) > 10 else "")
        sentences.append(f"Iterations or status differ from the stored ones: block{'s' * (len(others) > 1)} {blocks}.")
    return tuple(sentences)

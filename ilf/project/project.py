"""The project without its frames' states: the list of frames and the common settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from ..data.parameters import BlockParameters, Parameters
from ..data.presets import preset
from ..sources.frame_ref import FrameRef


class Stage(StrEnum):
    """Progress of the work on a frame; propagated: its blocks come from another frame and are unedited."""

    UNTOUCHED = "untouched"
    EXTRACTED = "extracted"
    PROPAGATED = "propagated"
    EDITED = "edited"
    RUN = "run"
    FAILED = "failed"


@dataclass(frozen=True)
class FrameSummary:
    """Summary of a frame for lists, available without loading the frame.

    Attributes
    ----------
    stage : Stage
    note : str
        The user's note.
    shape : (int, int) or None
        (H, W); None until the frame has been read.
    missing : float or None
        Share of pixels without depth, 0-1.
    blocks, completed, to_check : int
        Number of blocks, of blocks with an up-to-date result, and of blocks to check.
    problem : str
        Reason of the failure.
    own_parameters : bool
        Whether the frame has parameters of its own while the project's parameters apply to all frames.
    done : bool
        Whether the user has marked it as done.
    not_converged : int
        Number of blocks whose last run ended at a limit of iterations.
    """

    stage: Stage = Stage.UNTOUCHED
    note: str = ""
    shape: tuple[int, int] | None = None
    missing: float | None = None
    blocks: int = 0
    completed: int = 0
    to_check: int = 0
    problem: str = ""
    own_parameters: bool = False
    done: bool = False
    not_converged: int = field(default=0, metadata={"optional": True})

    @property
    def has_work(self) -> bool:
        """Whether the frame has a note or is done, or has work beyond extracted blocks."""
        return bool(self.note) or self.done or self.stage not in (Stage.UNTOUCHED, Stage.EXTRACTED)


@dataclass(frozen=True)
class ProjectFrame:
    """A frame in a project's list.

    Attributes
    ----------
    id : str
        Permanent id of the frame.
    name : str
    source : FrameRef or None
        Its files and how to read them; paths are absolute. None if the frame exists only in its stored state.
    summary : FrameSummary
    has_state : bool
        Whether the project contains a state of the frame; without one it is opened from its source.
    """

    id: str
    name: str
    source: FrameRef | None
    summary: FrameSummary = field(default_factory=FrameSummary)
    has_state: bool = False


@dataclass(frozen=True)
class Project:
    """A project without its frames' states.

    Attributes
    ----------
    frames : tuple of ProjectFrame
        In the order of the list.
    present : str
        Id of the frame viewed last; "" for none.
    common : Parameters
        With `for_all`, the parameters of all frames without parameters of their own; otherwise the initial parameters
        of the next frame.
    for_all : bool
        Whether the parameters apply to all frames.
    extraction : BlockParameters
        Parameters of the next block extraction.
    keeps_handmade : bool
        Whether the next extraction keeps blocks made by hand.
    view : mapping
        State of the window, as JSON values; not part of the work.
    """

    frames: tuple[ProjectFrame, ...] = ()
    present: str = ""
    common: Parameters = field(default_factory=preset)
    for_all: bool = False
    extraction: BlockParameters = field(default_factory=BlockParameters)
    keeps_handmade: bool = True
    view: Mapping[str, Any] = field(default_factory=dict)

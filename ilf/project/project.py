"""What a project holds beside its frames' states: which frames there are, and what is set for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from ..data.parameters import BlockParameters, Parameters, preset
from ..sources.frame_source import FrameSource


class Stage(StrEnum):
    """How far the work on a frame has come; carried: its blocks are those of another frame, as they came."""

    UNTOUCHED = "untouched"
    EXTRACTED = "extracted"
    CARRIED = "carried"
    EDITED = "edited"
    RUN = "run"
    FAILED = "failed"


@dataclass(frozen=True)
class FrameSummary:
    """What lists say of a frame without reading it.

    Attributes
    ----------
    stage : Stage
    note : str
        The user's.
    shape : (int, int) or None
        (H, W); None as long as nobody has read it.
    missing : float or None
        Share of pixels without depth, 0-1.
    blocks, completed, to_check : int
        Blocks, those of them that have a result as they are now, and those that need a look.
    problem : str
        Why it has failed.
    own_parameters : bool
        Whether its parameters are its own where they are for all frames.
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

    @property
    def is_worked_on(self) -> bool:
        """Whether anybody has done more with the frame than open it."""
        return bool(self.note) or self.stage not in (Stage.UNTOUCHED, Stage.EXTRACTED)


@dataclass(frozen=True)
class ProjectFrame:
    """A frame of a project, as its list has it.

    Attributes
    ----------
    id : str
        Stays with the frame.
    name : str
    source : FrameSource or None
        Where it is and how it is read; paths are absolute. None if it can be had from its stored state alone.
    summary : FrameSummary
    has_state : bool
        Whether the project holds a state of it; without one it is opened from its source.
    """

    id: str
    name: str
    source: FrameSource | None
    summary: FrameSummary = field(default_factory=FrameSummary)
    has_state: bool = False


@dataclass(frozen=True)
class Project:
    """All that a project holds beside its frames' states.

    Attributes
    ----------
    frames : tuple of ProjectFrame
        In the order of the list.
    present : str
        Id of the frame that was looked at last; "" for none.
    common : Parameters
        Of all frames that have no parameters of their own, where they are for all frames; otherwise what the next frame
        begins with.
    for_all : bool
        Whether parameters are for all frames.
    extraction : BlockParameters
        What blocks are extracted with the next time.
    keeps_handmade : bool
        Whether blocks that were made by hand stay then.
    view : mapping
        How the window was, in values that JSON has: no part of the work.
    """

    frames: tuple[ProjectFrame, ...] = ()
    present: str = ""
    common: Parameters = field(default_factory=preset)
    for_all: bool = False
    extraction: BlockParameters = field(default_factory=BlockParameters)
    keeps_handmade: bool = True
    view: Mapping[str, Any] = field(default_factory=dict)

"""What a report is about: a frame with its run, what came of it, and what is known of its blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from ..drawing.block_pictures import block_colour
from ..drawing.colour_tables import Colour
from ..outcomes import Completion
from ..project import FrameState, KeptRun
from ..project.stored import stored_completion
from ..run import Run


@dataclass(frozen=True, eq=False)
class Subject:
    """A frame to report on. Only the run and its completion are needed; what else there is, is told.

    Parameters
    ----------
    run : Run
        All blocks of the frame, and their parameters as they are set.
    completion : Completion
        What came of it; of no block, if nothing has been run yet.
    names, colours : mapping of int
        Block label -> what it is called, and its colour; others have their number and the colour of that.
    note : str
        The user's, of the frame.
    kept : tuple of KeptRun
        The runs that were kept of the frame.
    again : str
        The command by which it can be had again; worked out from the run if it is empty.
    problems : tuple of str
        What of it could not be read, a sentence each.
    """

    run: Run
    completion: Completion
    names: Mapping[int, str] = field(default_factory=dict)
    colours: Mapping[int, Colour] = field(default_factory=dict)
    note: str = ""
    kept: tuple[KeptRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """A frame as a project holds it, with its present results."""
        infos = state.notes.infos
        return cls(
            replace(state.run(), dense=state.guess is not None),
            stored_completion(state),
            {label: info.name for label, info in infos.items()},
            {label: info.colour for label, info in infos.items()},
            state.note,
            state.runs,
            again,
            problems,
        )

    def name_of(self, label: int) -> str:
        """What a block is called."""
        return self.names.get(label) or f"Block {label}"

    def colour_of(self, label: int) -> Colour:
        """The colour of a block."""
        return self.colours.get(label) or block_colour(label)


@dataclass(frozen=True)
class Unreadable:
    """A frame of a project that cannot be reported on, and why."""

    name: str
    why: str

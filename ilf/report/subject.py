"""The subjects of a report: frames with their runs, completions and blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from ..data.blocks import block_colour
from ..data.colour_maps import Colour
from ..data.results import Completion
from ..project.facts import present_completion
from ..project.frame_state import FrameState
from ..project.run_history import StoredRun
from ..run.run import Run


@dataclass(frozen=True, eq=False)
class Subject:
    """A frame to report on. Only the run and its completion are required.

    Parameters
    ----------
    run : Run
        All blocks of the frame, and their parameters as they are set.
    completion : Completion
        Its results; without blocks if nothing has been run yet.
    names, colours : mapping of int
        Block label -> name and colour; the defaults follow from the label.
    note : str
        The user's note on the frame.
    kept : tuple of StoredRun
        Run history of the frame.
    again : str
        Command that reproduces the run; derived from the run if empty.
    problems : tuple of str
        What could not be read, one sentence each.
    """

    run: Run
    completion: Completion
    names: Mapping[int, str] = field(default_factory=dict)
    colours: Mapping[int, Colour] = field(default_factory=dict)
    note: str = ""
    kept: tuple[StoredRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """Return the subject of a frame in a project, with its present results."""
        infos = state.blocks.infos
        return cls(
            replace(state.run(), extrapolate=state.extrapolation is not None),
            present_completion(state),
            {label: info.name for label, info in infos.items()},
            {label: info.colour for label, info in infos.items()},
            state.note,
            state.runs,
            again,
            problems,
        )

    def name_of(self, label: int) -> str:
        """Return the name of a block."""
        return self.names.get(label) or f"Block {label}"

    def colour_of(self, label: int) -> Colour:
        """Return the colour of a block."""
        return self.colours.get(label) or block_colour(label)


@dataclass(frozen=True)
class Unreadable:
    """A frame that cannot be reported on, and the reason."""

    name: str
    why: str

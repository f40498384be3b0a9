"""The subjects of a report: frames with their runs and completions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from ..data.blocks import block_colour
from ..data.pictures import Colour
from ..data.results import Completion
from ..project.frame_state import FrameState
from ..project.run_history import StoredRun
from ..run.run import Run


@dataclass(frozen=True, eq=False)
class Subject:
    """A frame to report on. Only its completion is required.

    Parameters
    ----------
    completion : Completion
        Its results, without blocks if nothing has been run yet; its run has all blocks of the frame, and their
        parameters as they are set.
    note : str
        The user's note on the frame.
    kept : tuple of StoredRun
        Run history of the frame.
    again : str
        Command that reproduces the run; "" if no run.json has been written yet.
    problems : tuple of str
        What could not be read, one sentence each.
    """

    completion: Completion
    note: str = ""
    kept: tuple[StoredRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """Return the subject of a frame in a project, with its present results."""
        run = replace(state.run(), extrapolate=state.extrapolation is not None)
        return cls(replace(state.present_completion(), run=run), state.note, state.runs, again, problems)

    @property
    def run(self) -> Run:
        """The run of the completion."""
        return self.completion.run

    def name_of(self, label: int) -> str:
        """Return the name of a block."""
        return self.run.blocks.names.get(label) or f"Block {label}"

    def colour_of(self, label: int) -> Colour:
        """Return the colour of a block."""
        return self.run.blocks.colours.get(label) or block_colour(label)


@dataclass(frozen=True)
class Unreadable:
    """A frame that cannot be reported on, and the reason."""

    name: str
    why: str

"""The subjects of a report: frames with their runs and completions, and the command that reproduces a run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ..data.blocks import block_colour
from ..data.declarations import ParameterSet, Value
from ..data.parameters import BlockParameters, nearest_preset
from ..data.pictures import Colour
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
    note: str = ""
    kept: tuple[StoredRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """Return the subject of a frame in a project, with its present results."""
        run = replace(state.run(), extrapolate=state.extrapolation is not None)
        return cls(run, present_completion(state), state.note, state.runs, again, problems)

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


# The command that reproduces a run.


def replay_text(run: Run) -> tuple[str, str]:
    """Return a sentence and the command that reproduces the run; the command is empty if there is none.

    Parameters
    ----------
    run : Run
    """
    inputs, frame = run.frame.inputs, run.frame
    if inputs is None:
        return "The frame was not read from files, so no command reproduces the run.", ""
    blocks = run.blocks
    by_hand = any(one is not None for one in (frame.invalid_mask, blocks.drawn, blocks.by_hand))
    edited = blocks.edited or blocks.own or by_hand
    why = ""
    if edited or blocks.extraction is None or (frame.guide is not None and frame.guide.path is None):
        why = "Blocks, parameters or depth were edited by hand"
    elif inputs.lenses is not None:
        why = "The frame was undistorted on reading"
    elif inputs.depth_to_colour is not None:
        why = "Depth was registered from a camera beside that of colour"
    if why or blocks.extraction is None:
        return f"{why}. Export the frame and replay its run.json.", "ilf complete --replay run.json"
    nearest = nearest_preset(run.parameters)
    files = [inputs.rgb.path, inputs.depth.path] if inputs.frame is None else [inputs.rgb.path, "--frame", inputs.frame]
    words = ["ilf", "complete", *files, "--depth-encoding", _text(inputs.encoding or inputs.depth_units)]
    for name in ("invalid", "dataset", "intrinsics", "depth_intrinsics", "view"):
        if (value := inputs.arguments.get(name)) is not None:
            words += [f"--{name.replace('_', '-')}", _text(value)]
    if frame.guide is not None and frame.guide.path is not None:
        words += ["--guide", frame.guide.path if frame.guide.network is None else frame.guide.network.name]
        words += ["--guide-gives", frame.guide.gives] if frame.guide.gives and frame.guide.network is None else []
    words += ["--preset", nearest.preset, *_flags(run.parameters, nearest.differs)]
    words += _flags(blocks.extraction, blocks.extraction.differences_from(BlockParameters()), "blocks-")
    words += ["--extrapolate"] * run.extrapolate
    return "This command reproduces the run; its run.json contains all hashes.", shlex.join(words)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ",".join(f"{number:.9g}" for number in np.ravel(value))


def _flags(values: ParameterSet, differing: Mapping[str, Value], prefix: str = "") -> list[str]:
    flags = []
    for name in filter(values.has_effect, differing):
        flag, value = f"{prefix}{name.replace('_', '-')}", differing[name]
        if isinstance(value, bool):
            flags.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            flags += [f"--{flag}", str(value)]
    return flags

"""The command that reproduces a run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..data.declarations import ParameterSet, Value
from ..data.parameters import BlockParameters, nearest_preset
from ..run.run import Run


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

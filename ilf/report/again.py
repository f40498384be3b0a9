"""How a run can be had again, as a command where one says it all."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

from ..declarations import ParameterSet, Value
from ..parameters import BlockParameters
from ..preset_words import likeness
from ..run import Run


def again_text(run: Run) -> tuple[str, str]:
    """A sentence, and the command line that makes the run again; the latter is empty where no flags can say it.

    Parameters
    ----------
    run : Run
    """
    inputs, frame = run.frame.inputs, run.frame
    if inputs is None:
        return "The frame was not read from files, so no command makes it again.", ""
    by_hand = run.edited or run.own or frame.distrusted is not None or run.drawn is not None
    if by_hand or run.extraction is None or (frame.guide is not None and frame.guide.path is None):
        return (
            "Blocks, values or depth were set by hand. Export the frame: its run.json makes the run again.",
            "ilf complete --replay run.json",
        )
    nearest = likeness(run.parameters)
    encoding = f"{inputs.depth_units:.9g}" if inputs.encoding is None else inputs.encoding
    files = [inputs.rgb.path, inputs.depth.path] if inputs.frame is None else [inputs.rgb.path, "--frame", inputs.frame]
    words = ["ilf", "complete", *files, "--depth-encoding", encoding]
    if inputs.invalid is not None:
        words += ["--invalid", f"{inputs.invalid:.9g}"]
    if inputs.intrinsics is not None:
        words += ["--intrinsics", ",".join(f"{number:.9g}" for number in inputs.intrinsics)]
    if frame.guide is not None and frame.guide.path is not None:
        words += ["--guide", frame.guide.path]
    words += ["--preset", nearest.preset, *_flags(run.parameters, nearest.differs)]
    words += _flags(run.extraction, run.extraction.unlike(BlockParameters()), "blocks-")
    words += ["--dense"] * run.dense
    return "This command makes the run again; its run.json holds all hashes.", shlex.join(words)


def _flags(values: ParameterSet, differing: Mapping[str, Value], prefix: str = "") -> list[str]:
    flags = []
    for name in filter(values.matters, differing):
        flag, value = f"{prefix}{name.replace('_', '-')}", differing[name]
        if isinstance(value, bool):
            flags.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            flags += [f"--{flag}", str(value)]
    return flags

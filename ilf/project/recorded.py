"""What a part `frames/<id>.json` says of itself: which frame it is of, its files, and the arrays that it refers to."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np

from ..camera import CameraIntrinsics
from ..errors import FormatError, IlfError
from ..frame import InputFile, RGBDFrame
from ..run.record_file import parsed_inputs
from ..sections import Section
from .encoding import frame_part
from .frame_state import FrameState
from .packing import Npz, check_content, colour_from_bytes, mask_from_bytes
from .parts import Parts
from .sources import Places, load_inputs

UNREADABLE = (IlfError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""What reading somebody's bytes may raise, whatever is wrong with them."""


def read_frame_part(frame_id: str, parts: Parts) -> Section:
    """The part with a frame's state; raises FormatError if it is damaged, InputError if there is none."""
    return parsed_frame_part(parts.read(frame_part(frame_id)))


def parsed_frame_part(content: bytes) -> Section:
    """The same, from its bytes."""
    try:
        data = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise FormatError(f"The frame's part is no JSON ({error}).") from error
    if not isinstance(data, dict):
        raise FormatError("The frame's part holds no JSON object.")
    return Section("frame's part", data)


def recorded_frame(data: Section, parts: Parts, places: Places | None) -> RGBDFrame:
    """The frame as its files, or what is kept of it, have it."""
    name, shape = data.get("name", str), recorded_shape(data)
    camera = None
    if data.get("intrinsics", list, type(None)) is not None:
        fx, fy, cx, cy, called = data.get("intrinsics", list)
        camera = CameraIntrinsics(float(fx), float(fy), float(cx), float(cy), str(called))
    stated: dict[str, Any] = {}
    if "pose" in data.values:
        stated["pose"] = data.get("pose", list)
    if "outside_view" in data.values:
        outside = data.get("outside_view", str)
        stated["outside_view"] = mask_from_bytes(outside, array_content(parts, outside), shape)
    if "inputs" in data.values:
        frame = load_inputs(parsed_inputs(data.section("inputs")), name, camera, parts, places)
        return dataclasses.replace(frame, **stated)
    colour, depth = data.get("rgb", str), data.get("depth", str)
    return RGBDFrame(
        colour_from_bytes(colour, array_content(parts, colour), shape),
        Npz(depth, array_content(parts, depth)).array("depth", np.float32, shape),
        camera,
        name,
        **stated,
    )


def array_content(parts: Parts, name: str) -> bytes:
    """The bytes of a part with an array; raises InputError if it is not there, FormatError if it is damaged."""
    content = parts.read(name)
    check_content(name, content)
    return content


def recorded_shape(data: Section) -> tuple[int, int]:
    """Height and width of the frame."""
    height, width = data.items("shape", int)
    return height, width


def files_of(frame_json: bytes) -> tuple[InputFile, ...]:
    """The files that the state in a part `frames/<id>.json` was made with: colour, depth, truths; each once.

    A recording comes without a SHA-256: it is known by the frame in it.

    Raises
    ------
    FormatError
        If the part is damaged.
    """
    data = parsed_frame_part(frame_json)
    frame = data.section("frame")
    files: list[InputFile] = []
    if "inputs" in frame.values:
        inputs = parsed_inputs(frame.section("inputs"))
        pair = (inputs.rgb, inputs.depth) if inputs.frame is None else (InputFile(inputs.rgb.path, ""),)
        files += [file for file in (*pair, inputs.truth) if file is not None]
    runs = [Section("kept run", run).section("run") for run in data.items("runs", dict)]
    for part in (data, *runs):
        if part.get("truth", dict, type(None)) is not None and "path" in part.section("truth").values:
            truth = part.section("truth")
            files.append(InputFile(truth.get("path", str), truth.get("sha256", str)))
    return tuple({(file.path, file.sha256): file for file in files}.values())


def arrays_of(frame_json: bytes) -> frozenset[str]:
    """All parts with arrays that a part `frames/<id>.json` refers to; raises FormatError if it is damaged."""
    return frozenset(parsed_frame_part(frame_json).items("arrays", str))


def bare_state(frame_id: str, frame: RGBDFrame) -> FrameState:
    """A frame that nobody has worked on."""
    labels = np.zeros(frame.shape, np.int32)
    labels.setflags(write=False)
    return FrameState(frame_id, frame, labels)

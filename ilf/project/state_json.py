"""Reading the JSON of a part `frames/<id>.json`: the frame, its files, and the arrays that it refers to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._runtime.files import parse_json
from .._runtime.schema import Section, check_schema
from ..data.camera import CameraIntrinsics
from ..data.frame import InputFile, RGBDFrame
from ..data.parameters import Parameters
from ..errors import FormatError, IlfError
from ..run.record_file import parsed_inputs
from .archive import Parts
from .encoding import SCHEMA, frame_part
from .frame_state import FrameState, InspectionState, OwnValues, Point
from .packing import Npz, check_content, colour_from_bytes, mask_from_bytes
from .sources import Places, load_inputs

UNREADABLE = (IlfError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""Exceptions of reading damaged or foreign data."""

_Camera = tuple[float, float, float, float, str]
_Ends = tuple[int, int]


def read_frame_part(frame_id: str, parts: Parts) -> Section:
    """Read the part with a frame's state; raises FormatError if it is damaged, InputError if there is none."""
    return parsed_frame_part(parts.read(frame_part(frame_id)))


def parsed_frame_part(content: bytes) -> Section:
    """Parse the bytes of the part with a frame's state; raises FormatError if it is damaged."""
    data = parse_json(content, "The frame's part")
    if not isinstance(data, dict):
        raise FormatError("The frame's part is not a JSON object.")
    check_schema(data, SCHEMA, "frame's part")
    return Section("frame's part", data)


def recorded_frame(data: Section, parts: Parts, places: Places | None) -> RGBDFrame:
    """Load the frame from its files, or from its stored arrays."""
    name, shape = data.get("name", str), recorded_shape(data)
    camera = None
    if (stated_camera := data.get("intrinsics", _Camera, None)) is not None:
        camera = CameraIntrinsics(*stated_camera)
    stated: dict[str, Any] = {}
    if "pose" in data.values:
        stated["pose"] = data.get("pose", list)
    if "outside_view" in data.values:
        outside = data.get("outside_view", str)
        stated["outside_view"] = mask_from_bytes(outside, array_content(parts, outside), shape)
    if "inputs" in data.values:
        frame = load_inputs(parsed_inputs(data.get("inputs", dict)), name, camera, parts, places)
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
    """Read the bytes of a part with an array; raises InputError if it is missing, FormatError if it is damaged."""
    content = parts.read(name)
    check_content(name, content)
    return content


def recorded_shape(data: Section) -> tuple[int, int]:
    """Return height and width of the frame."""
    shape: tuple[int, int] = data.get("shape", tuple[int, int])
    return shape


def files_of(frame_json: bytes) -> tuple[InputFile, ...]:
    """List the files of the state in a part `frames/<id>.json`: colour, depth, ground truth; each once.

    A recording has no SHA-256: it is identified by the frame in it.

    Raises
    ------
    FormatError
        If the part is damaged.
    """
    data = parsed_frame_part(frame_json)
    frame = data.section("frame")
    files: list[InputFile] = []
    if "inputs" in frame.values:
        inputs = parsed_inputs(frame.get("inputs", dict))
        pair = (inputs.rgb, inputs.depth) if inputs.frame is None else (InputFile(inputs.rgb.path, ""),)
        files += [file for file in (*pair, inputs.ground_truth) if file is not None]
    runs = [Section("stored run", run).section("run") for run in data.items("runs", dict)]
    for part in (data, *runs):
        if "path" in (part.get("ground_truth", dict, None) or {}):
            files.append(part.get("ground_truth", InputFile))
    return tuple({(file.path, file.sha256): file for file in files}.values())


def arrays_of(frame_json: bytes) -> frozenset[str]:
    """List all parts with arrays that a part `frames/<id>.json` refers to; raises FormatError if it is damaged."""
    return frozenset(parsed_frame_part(frame_json).items("arrays", str))


def empty_state(frame_id: str, frame: RGBDFrame) -> FrameState:
    """Return the state of a frame without any work."""
    labels = np.zeros(frame.shape, np.int32)
    labels.setflags(write=False)
    return FrameState(frame_id, frame, labels)


# Readers of the fields without arrays, from a state's JSON; for damaged data they raise one of UNREADABLE.


def result_rows(data: Section, frame_part: Section) -> list[tuple[int, str, int]]:
    """Return label, pack and index in the pack of every result."""
    packs = frame_part.items("packs", str)
    rows = data.get("results", list[tuple[int, int, int]])
    return [(label, packs[pack], place) for label, pack, place in rows if 0 <= pack < len(packs)]


def own_values_of(data: Section) -> dict[int, OwnValues]:
    """Return the own parameters of blocks, by label."""
    own = data.get("own", dict[int, dict[str, Any]])
    checked = {label: Parameters().replace(**values).to_dict() for label, values in own.items()}
    return {label: {name: checked[label][name] for name in values} for label, values in own.items()}


def selected_labels(data: Section) -> Sequence[int] | frozenset[int]:
    """Return the selected blocks of a run, in their order if they had one."""
    labels = data.items("only", int)
    return tuple(labels) if data.get("in_order", bool) else frozenset(labels)


def number_or_none(data: Section, key: str) -> float | None:
    """Return an error; None if it was not computed, NaN if it is undefined."""
    if key not in data.values:
        return None
    number: float | None = data.get(key, float, None)
    return math.nan if number is None else number


def inspection_of(data: Section) -> InspectionState:
    """Return the user's inspections of the frame."""
    region = data.get("region", tuple[_Ends, _Ends], None)
    return InspectionState(
        data.get("line", tuple[Point, Point], None),
        None if region is None else (slice(*region[0]), slice(*region[1])),
        data.get("measurements", tuple[tuple[Point, Point], ...]),
    )

"""The JSON of a part `frames/<id>.json`, as types that declare it; it is read whole, and strictly."""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np
from msgspec import UNSET, Struct, UnsetType

from .._runtime.files import parse_json
from .._runtime.schema import check_schema, converted
from ..data.blocks import BlockInfo, Blocks, Colour
from ..data.frame import InputFile, RGBDFrame
from ..data.parameters import BlockParameters, Parameters
from ..errors import FormatError, IlfError
from ..evaluation.hold_out import HoldOutTest
from ..evaluation.quality.ignored import IgnoredPlace
from ..run.record import RecordedNeighbour
from ..run.record_file import parsed_inputs
from .archive import Parts
from .encoding import SCHEMA, frame_part
from .frame_state import FrameState, Point
from .packing import check_content

UNREADABLE = (IlfError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""Exceptions of reading damaged or foreign data."""

_Ends = tuple[int, int]
_Error = float | UnsetType | None
"""An error: null if it is undefined, no key if it was not computed."""
_Rows = list[tuple[int, int, int]]
"""Label, index in `packs` and index in that pack, of each result."""


class FrameJson(Struct):
    """The frame: by its files (`inputs`), or by its arrays."""

    name: str
    shape: tuple[int, int]
    measured: str
    intrinsics: tuple[float, float, float, float, str] | None
    inputs: dict[str, Any] | None = None
    rgb: str | None = None
    depth: str | None = None
    pose: list[list[float]] | None = None
    outside_view: str | None = None


class GuideJson(Struct):
    """A guide."""

    values: str
    confidence: str | None
    path: str | None


class NeighboursJson(Struct):
    """Depth of neighbours."""

    layers: str
    used: tuple[RecordedNeighbour, ...]


class ByHandJson(Struct):
    """Depth by hand."""

    depth: str
    weight: float


class LayersJson(Struct, kw_only=True):
    """What a frame has beside colour and depth."""

    invalid_mask: str | None
    ground_truth: dict[str, Any] | None
    guide: GuideJson | None = None
    neighbours: NeighboursJson | None = None


class NotesJson(Struct):
    """The notes of blocks."""

    infos: dict[int, BlockInfo]
    own: dict[int, dict[str, Any]]
    drawn: str | None
    extraction: BlockParameters | None
    network: str | None
    extracted: str | None
    kept: frozenset[int]
    handmade: frozenset[int]
    propagated_from: str
    reasons: dict[int, str]
    notes: tuple[str, ...]


class RunJson(LayersJson, kw_only=True):
    """A run."""

    blocks: str
    parameters: Parameters
    own: dict[int, dict[str, Any]]
    only: tuple[int, ...] | None
    in_order: bool
    extrapolate: bool
    extraction: BlockParameters | None
    edited: bool
    network: str | None
    notes: tuple[str, ...]
    drawn: str | None
    by_hand: ByHandJson | None = None


class ExtrapolationJson(Struct):
    """Extrapolated depth."""

    array: str
    count: int
    notes: tuple[str, ...]
    network: str | None


class StoredRunJson(Struct, kw_only=True):
    """A run of the run history."""

    number: int
    name: str
    run: RunJson
    results: _Rows
    seconds: float
    colour: Colour
    note: str
    when: datetime.datetime
    done: frozenset[int]
    how: str
    extrapolation: ExtrapolationJson | None
    hold_out_test: HoldOutTest | None
    ground_truth_error: _Error = UNSET
    hold_out_error: _Error = UNSET
    expected_error: _Error = UNSET


class InspectionJson(Struct):
    """The user's inspections."""

    line: tuple[Point, Point] | None
    region: tuple[_Ends, _Ends] | None
    measurements: tuple[tuple[Point, Point], ...]


class StateJson(LayersJson, kw_only=True):
    """A frame's state; arrays are names of parts."""

    frame: FrameJson
    by_hand: ByHandJson | None = None
    labels: str
    notes: NotesJson
    parameters: Parameters
    packs: tuple[str, ...]
    results: _Rows
    extrapolation: ExtrapolationJson | None
    runs: tuple[StoredRunJson, ...]
    compared: tuple[int, ...]
    next_number: int
    extrapolate: bool
    own_parameters: bool
    note: str
    done: bool
    to_check: frozenset[int]
    ignored: tuple[IgnoredPlace, ...]
    selected: tuple[int, ...]
    looked: InspectionJson
    view: dict[str, Any]
    arrays: frozenset[str]


def read_frame_part(frame_id: str, parts: Parts) -> StateJson:
    """Read the part with a frame's state; raises FormatError if it is damaged, InputError if there is none."""
    return parsed_frame_part(parts.read(frame_part(frame_id)))


def parsed_frame_part(content: bytes) -> StateJson:
    """Parse the bytes of the part with a frame's state; raises FormatError if it is damaged."""
    data = parse_json(content, "The frame's part")
    if not isinstance(data, dict):
        raise FormatError("The frame's part is not a JSON object.")
    check_schema(data, SCHEMA, "frame's part")
    return converted(data, StateJson, "frame's part")


def array_content(parts: Parts, name: str) -> bytes:
    """Read the bytes of a part with an array; raises InputError if it is missing, FormatError if it is damaged."""
    content = parts.read(name)
    check_content(name, content)
    return content


def files_of(stored: StateJson) -> tuple[InputFile, ...]:
    """List the files of a frame's state: colour, depth, ground truth; each once. Raises FormatError for wrong values.

    A recording has no SHA-256: it is identified by the frame in it.
    """
    files: list[InputFile] = []
    if stored.frame.inputs is not None:
        inputs = parsed_inputs(stored.frame.inputs)
        pair = (inputs.rgb, inputs.depth) if inputs.frame is None else (InputFile(inputs.rgb.path, ""),)
        files += [file for file in (*pair, inputs.ground_truth) if file is not None]
    layers: list[LayersJson] = [stored, *(run.run for run in stored.runs)]
    truths = [one.ground_truth for one in layers if one.ground_truth is not None]
    files += [converted(truth, InputFile, "ground truth") for truth in truths if "path" in truth]
    return tuple({(file.path, file.sha256): file for file in files}.values())


def error_or_none(error: _Error) -> float | None:
    """Return an error; None if it was not computed, NaN if it is undefined."""
    if error is UNSET:
        return None
    return float("nan") if error is None else error


def empty_state(frame_id: str, frame: RGBDFrame) -> FrameState:
    """Return the state of a frame without any work."""
    labels = np.zeros(frame.shape, np.int32)
    labels.setflags(write=False)
    return FrameState(frame_id, frame, Blocks(labels))

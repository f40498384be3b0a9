"""The part with a frame's state: its JSON, which names the parts with its arrays and results."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import parse_json
from .._runtime.installation import __version__
from .._runtime.schema import PROGRAM, check_schema, converted
from ..data.arrays import frozen
from ..data.blocks import Blocks, checked_labels
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..data.frame_cache import FrameCache
from ..data.results import BlockResult
from ..errors import FormatError, InputError
from ..io.encodings import encoding_of_inputs
from ..sources.named_places import NotAllowed
from .archive import Parts
from .codec import UNREADABLE, from_plain, inline, pack, small_array, stored_fields, to_plain, unpack
from .frame_state import FrameState
from .run_history import Extrapolation
from .sources import MissingSource, Places, load_inputs, with_ground_truth

SCHEMA = 2
"""Version of the format of a project's parts."""

_PACK_BYTES = 2**26
"""Size of the depth of results [bytes] from which a new part is begun."""

_OF_FILES = {"rgb", "depth", "notes", "plausibility_warnings", "invalid_marker", "brought"}
"""What a frame that was read from files has from them."""

Origin = str | tuple[str, int]
"""The part that an object is stored in, for results with the place in it."""

IsThere = Callable[[str], bool]
"""Whether there is a part of a name."""


Known = FrameCache[Any, Origin]
"""The objects of states that are stored, and where; it does not keep them alive. Thread-safe."""


class UnreadableFrame(InputError):
    """The stored state of a frame is damaged, or of another version."""


def frame_part(frame_id: str) -> str:
    """Return the name of the part with a frame's state."""
    return f"frames/{frame_id}.json"


def thumbnail_part(frame_id: str) -> str:
    """Return the name of the part with a frame's thumbnail."""
    return f"thumbnails/{frame_id}.jpg"


# Writing.


@dataclass(frozen=True)
class Encoded:
    """A frame's state as bytes.

    Attributes
    ----------
    content : bytes
        Of the part `frame_part(id)`.
    made : dict of str to bytes
        The parts that it names and that were not known.
    names : frozenset of str
        All parts that it names.
    """

    content: bytes
    made: dict[str, bytes]
    names: frozenset[str]


def encode(state: FrameState, known: Known | None = None, is_there: IsThere = lambda name: True) -> Encoded:
    """Encode a state. Only arrays and results that are not `known` from the last time, or from reading, or whose part
    is there no more, are encoded; they are known then.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((20, 30, 3), np.uint8), np.full((20, 30), 2.0))
    >>> state = FrameState("a1", frame, Blocks(np.ones((20, 30), np.int32)))
    >>> state.blocks.labels.setflags(write=False)
    >>> known = Known()
    >>> len(encode(state, known).made), len(encode(state, known).made)
    (3, 0)
    """
    writer = _Writer(known or Known(), is_there)
    value = to_plain(state, writer.hooks)
    writer.close_pack()
    head = {"program": PROGRAM, "schema": SCHEMA, "version": __version__}
    files = [vars(file) for file in dict.fromkeys(writer.files)]
    names = list(writer.parts)
    content = json.dumps(
        head | {"parts": names, "files": files, "state": value}, separators=(",", ":"), allow_nan=False
    )
    return Encoded(content.encode(), writer.made, frozenset(names))


class _Writer:
    """The hooks of one state."""

    def __init__(self, known: Known, is_there: IsThere) -> None:
        self.known, self.is_there = known, is_there
        self.parts: dict[str, int] = {}
        """Name of a part -> its number, by which the JSON refers to it."""
        self.made: dict[str, bytes] = {}
        self.files: list[InputFile] = []
        self.hooks: dict[type, Callable[[Any], Any]] = {
            np.ndarray: self._array,
            RGBDFrame: self._frame,
            BlockResult: self._result,
        }
        self._waiting: list[tuple[BlockResult, list[int]]] = []
        """Results that are not stored yet, and their places in the JSON."""

    def _array(self, array: NDArray[Any]) -> Any:
        if (small := inline(array)) is not None:
            return small
        name = self._stored(array)
        if not isinstance(name, str):
            name, content = pack(array)
            self.made[name] = content
            if not array.flags.writeable:
                self.known.keep(array, None, name)
        return self._number(name)

    def _stored(self, value: object) -> Origin | None:
        """Return where an object is stored; None if it is to be encoded."""
        origin = self.known.find(value, None)
        part = origin[0] if isinstance(origin, tuple) else origin
        return origin if part is not None and (part in self.made or self.is_there(part)) else None

    def _number(self, name: str) -> int:
        return self.parts.setdefault(name, len(self.parts))

    def _frame(self, frame: RGBDFrame) -> Any:
        values = {name: getattr(frame, name) for name in stored_fields(RGBDFrame)} | {"depth": frame.measured}
        inputs = frame.inputs
        if inputs is not None:
            self.files += files_of(inputs)
            values = {name: value for name, value in values.items() if name not in _of_files(inputs)}
        return to_plain(values, self.hooks)

    def _result(self, result: BlockResult) -> list[int]:
        stored = self._stored(result)
        if isinstance(stored, tuple):
            return [self._number(stored[0]), stored[1]]
        for waiting, place in self._waiting:
            if waiting is result:
                return place
        self._waiting.append((result, [0, len(self._waiting)]))
        place = self._waiting[-1][1]
        if sum(waiting.depth.nbytes for waiting, _ in self._waiting) > _PACK_BYTES:
            self.close_pack()
        return place

    def close_pack(self) -> None:
        """Store the waiting results."""
        if not self._waiting:
            return
        name, content = pack([result for result, _ in self._waiting])
        self.made[name] = content
        for result, place in self._waiting:
            place[0] = self._number(name)
            self.known.keep(result, None, (name, place[1]))
        self._waiting = []


def files_of(inputs: FrameInputs) -> tuple[InputFile, ...]:
    """List the files of a frame: colour, depth, ground truth. A recording has no SHA-256: it is identified by the frame
    in it."""
    pair = (inputs.rgb, inputs.depth) if inputs.frame is None else (InputFile(inputs.rgb.path, ""),)
    truth = inputs.ground_truth
    return (*pair, *(() if truth is None else (InputFile(truth.path, truth.sha256),)))


def _of_files(inputs: FrameInputs) -> set[str]:
    """Return the fields of a frame that its files contain."""
    truth = {"ground_truth"} if inputs.ground_truth is not None else set()
    return _OF_FILES | truth | ({"outside_view"} if inputs.frame is not None else set())


# Reading.


@dataclass(frozen=True)
class FrameHead:
    """What the part with a frame's state says of it, read without its arrays.

    Attributes
    ----------
    parts : tuple of str
        The parts that it names.
    files : tuple of InputFile
        The files of the frame.
    state : dict
        The JSON of the state.
    """

    parts: tuple[str, ...]
    files: tuple[InputFile, ...]
    state: dict[str, Any]


def read_head(content: bytes) -> FrameHead:
    """Parse the part with a frame's state; raises FormatError if it is damaged or of another schema."""
    data = parse_json(content, "The frame's part")
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError("It was not written by this program.")
    check_schema(data, SCHEMA, "frame's part")
    return converted(data, FrameHead, "frame's part")


@dataclass(frozen=True, eq=False)
class Decoded:
    """A frame's state as it was stored.

    Attributes
    ----------
    state : FrameState
    problems : tuple of str
        Why its ground truth, whose file stays listed, is not available; one sentence each.
    """

    state: FrameState
    problems: tuple[str, ...] = ()


def load_state(frame_id: str, parts: Parts, places: Places | None = None, known: Known | None = None) -> Decoded:
    """Load a frame, from its files or from the project, with all work on it.

    Parameters
    ----------
    frame_id : str
    parts : Parts
        Store with `frames/<id>.json` and the parts that it names.
    places : Places, optional
        Possible locations of its files.
    known : Known, optional
        Notes what is read, for `encode`.

    Raises
    ------
    MissingSource
        If one of its files was not found, or has changed.
    UnreadableFrame
        If any part of its state is missing, damaged or of another version.
    """
    try:
        head = read_head(parts.read(frame_part(frame_id)))
        reader = _Reader(head, parts, places, known or Known())
        state: FrameState = replace(from_plain(head.state, FrameState, reader.hooks), id=frame_id)
        _check(state)
    except (MissingSource, NotAllowed):
        raise
    except UNREADABLE as error:
        raise UnreadableFrame(f"The work on this frame cannot be read: {error}") from error
    return Decoded(state, tuple(dict.fromkeys(reader.problems)))


class _Reader:
    """The hooks of one state: equal references share one object."""

    def __init__(self, head: FrameHead, parts: Parts, places: Places | None, known: Known) -> None:
        self.head, self.parts, self.places, self.known = head, parts, places, known
        self.problems: list[str] = []
        self.hooks: dict[type, Callable[[Any, Any], Any]] = {
            np.ndarray: self._array,
            RGBDFrame: self._frame,
            BlockResult: self._result,
        }
        self._made: dict[str, Any] = {}

    def _once(self, key: object, make: Callable[[], Any]) -> Any:
        text = json.dumps(key, sort_keys=True)
        if text not in self._made:
            self._made[text] = make()
        return self._made[text]

    def _part(self, number: object, kind: Any) -> Any:
        name = self.head.parts[converted(number, int, "reference")]
        return self._once([name, str(kind)], lambda: unpack(name, self.parts.read(name), kind))

    def _array(self, data: Any, hint: Any) -> NDArray[Any]:
        if isinstance(data, list):
            return small_array(data, hint)
        array: NDArray[Any] = self._part(data, hint)
        self.known.keep(array, None, self.head.parts[data])
        return array

    def _result(self, data: Any, hint: Any) -> BlockResult:
        number, place = converted(data, tuple[int, int], "reference")
        results = self._part(number, tuple[BlockResult, ...])
        if place < 0:
            raise FormatError("A reference is not valid.")
        result: BlockResult = results[place]
        self.known.keep(result, None, (self.head.parts[number], place))
        return result

    def _frame(self, data: Any, hint: Any) -> RGBDFrame:
        frame: RGBDFrame = self._once(["frame", data], lambda: self._made_frame(data))
        return frame

    def _made_frame(self, data: dict[str, Any]) -> RGBDFrame:
        stated = stored_fields(RGBDFrame)
        inputs: FrameInputs | None = from_plain(data["inputs"], stated["inputs"], {})
        wanted = stated.keys() - (set() if inputs is None else _of_files(inputs))
        if data.keys() != wanted:
            raise FormatError("The frame has other fields.")
        values = {name: from_plain(data[name], stated[name], self.hooks) for name in stated if name in data}
        if inputs is None:
            frame = RGBDFrame(values["rgb"], values["depth"])
        else:
            encoding_of_inputs(inputs)  # refuses unknown encodings
            of_base = {name: data[name] for name in ("inputs", "name", "intrinsics")}
            frame = self._once(["files", of_base], lambda: self._of_files(inputs, values))
        others = {name: value for name, value in values.items() if name not in {"rgb", "depth", "inputs"}}
        frame = replace(frame, **{name: value for name, value in others.items() if value is not None})
        for name, number in data.items():
            kept = frame.measured if name == "depth" else getattr(frame, name)
            if isinstance(number, int) and isinstance(kept, np.ndarray):
                self.known.keep(kept, None, self.head.parts[number])
        return frame

    def _of_files(self, inputs: FrameInputs, values: dict[str, Any]) -> RGBDFrame:
        frame = load_inputs(inputs, values["name"], values["intrinsics"], self.parts, self.places)
        truth = inputs.ground_truth
        if truth is None:
            return frame
        try:
            return with_ground_truth(frame, truth, self.parts, self.places)
        except InputError as error:
            self.problems.append(f"The ground truth is not available: {error}")
            return frame.with_ground_truth(None, truth)  # the file stays listed and may be available the next time


def _check(state: FrameState) -> None:
    """Raise FormatError, or another of `UNREADABLE`, if parts of a state do not fit each other."""
    shape, size = state.frame.shape, state.frame.depth.size
    blocks = state.blocks
    checked_labels(blocks.labels, shape)
    beside = [blocks.drawn, blocks.extracted, None if blocks.by_hand is None else blocks.by_hand.depth]
    if any(array is not None and array.shape != shape for array in beside):
        raise FormatError("An array is of another size than the frame.")
    for own in blocks.own.values():
        state.common.replace(**own)
    for results in (state.results, *(kept.results for kept in state.runs)):
        for label, result in results.items():
            _check_result(label, result, shape)
    for extrapolation in (state.extrapolation, *(kept.extrapolation for kept in state.runs)):
        if extrapolation is not None:
            _check_pixels(extrapolation, size)


def _check_result(label: int, result: BlockResult, shape: tuple[int, int]) -> None:
    block, (rows, columns) = result.block, result.block.box
    inside = 0 <= rows.start < rows.stop <= shape[0] and 0 <= columns.start < columns.stop <= shape[1]
    pixels = np.count_nonzero(block.mask)
    beside = [result.depth, result.drawn, None if result.by_hand is None else result.by_hand.depth]
    if not inside or block.label != label or block.mask.shape != (rows.stop - rows.start, columns.stop - columns.start):
        raise FormatError(f"The result of block {label} is not in the frame.")
    if any(array is not None and array.shape != (pixels,) for array in beside):
        raise FormatError(f"The result of block {label} has another number of pixels.")


def _check_pixels(extrapolation: Extrapolation, size: int) -> None:
    pixels, depth = extrapolation.pixels, extrapolation.depth
    if (
        pixels.shape != depth.shape
        or pixels.ndim != 1
        or (pixels.size and not 0 <= pixels.min() <= pixels.max() < size)
    ):
        raise FormatError("The extrapolated pixels lie outside the frame.")


def empty_state(frame_id: str, frame: RGBDFrame) -> FrameState:
    """Return the state of a frame without any work."""
    return FrameState(frame_id, frame, Blocks(frozen(np.zeros(frame.shape, np.int32))))

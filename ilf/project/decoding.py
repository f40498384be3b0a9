"""Decoding a frame's state from its parts; a damaged part loses only its own content, and is reported."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.named_places import NotAllowed
from .._runtime.schema import Section
from ..data.by_hand import DepthByHand
from ..data.frame import GroundTruthFile, RGBDFrame
from ..data.guide import Guide
from ..data.neighbours import NeighbourDepth
from ..data.parameters import BlockParameters, Parameters
from ..data.presets import preset
from ..data.results import BlockResult
from ..errors import FormatError, InputError
from ..evaluation.hold_out import HoldOutTest
from ..evaluation.quality.ignored import IgnoredPlace
from ..run.record import RecordedNeighbour
from ..run.run import Run
from ..sources.frame_source import FrameSource
from .archive import Parts
from .encoding import Origin, measured_sha256
from .frame_state import BlockInfo, BlockNotes, FrameState
from .packing import Npz, labels_from_bytes, mask_from_bytes
from .result_packs import unpack_results
from .run_history import Colour, Extrapolation, StoredRun
from .sources import ChangedSource, MissingSource, Places, with_ground_truth
from .state_json import (
    UNREADABLE,
    array_content,
    empty_state,
    inspection_of,
    number_or_none,
    own_values_of,
    read_frame_part,
    recorded_frame,
    recorded_shape,
    result_rows,
    selected_labels,
)

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Decoded:
    """The readable part of a frame's state.

    Attributes
    ----------
    state : FrameState
    problems : tuple of str
        What could not be read, with the consequence; one sentence each.
    origins : tuple
        Arrays and results with the part that each was read from, for `Encoder.learn`.
    names : frozenset of str
        All parts with arrays that were read.
    """

    state: FrameState
    problems: tuple[str, ...] = ()
    origins: tuple[tuple[object, Origin], ...] = ()
    names: frozenset[str] = frozenset()


def load_state(frame_id: str, parts: Parts, source: FrameSource | None = None, places: Places | None = None) -> Decoded:
    """Load a frame, from its files or from the project, with all work on it.

    Parameters
    ----------
    frame_id : str
    parts : Parts
    source : FrameSource, optional
        Files to open the frame from if the list of its files in the project is damaged.
    places : Places, optional
        Possible locations of its files.

    Raises
    ------
    MissingSource, ChangedSource
        If one of its files was not found, or has changed.
    InputError
        If the frame cannot be loaded.
    """
    try:
        frame = recorded_frame(read_frame_part(frame_id, parts).section("frame"), parts, places)
    except (MissingSource, ChangedSource, NotAllowed):
        raise
    except UNREADABLE as error:
        if source is None:
            raise InputError(f"The frame cannot be read from the project: {error}") from error
        frame = source.load()
    return decode(frame_id, parts, frame, places)


def decode(frame_id: str, parts: Parts, frame: RGBDFrame, places: Places | None = None) -> Decoded:
    """Decode the state of a frame.

    Parameters
    ----------
    frame_id : str
    parts : Parts
        Store with `frames/<id>.json` and the parts that it refers to.
    frame : RGBDFrame
        As read from its files; invalid mask, ground truth, guide and neighbours are taken from the state.
    places : Places, optional
        Possible locations of its ground-truth file.

    Returns
    -------
    Decoded
        Unreadable content is as in a new frame, and reported in `problems`.
    """
    decoding = _Decoding(parts, frame, places)
    state = decoding.state(frame_id)
    return Decoded(state, tuple(dict.fromkeys(decoding.problems)), tuple(decoding.origins), frozenset(decoding.names))


class _Decoding:
    """Decodes one state."""

    def __init__(self, parts: Parts, frame: RGBDFrame, places: Places | None) -> None:
        self.parts, self.frame, self.places = parts, frame, places
        self.problems: list[str] = []
        self.origins: list[tuple[object, Origin]] = []
        self.names: set[str] = set()
        self.arrays: dict[tuple[str, object], NDArray[Any]] = {}
        self.frames: dict[str, RGBDFrame] = {}
        self.guides: dict[str, Guide] = {}
        self.neighbours: dict[str, NeighbourDepth] = {}
        self.by_hands: dict[str, DepthByHand] = {}
        self.packs: dict[str, list[BlockResult]] = {}
        self.same_depth = True

    def state(self, frame_id: str) -> FrameState:
        """Decode the whole state."""
        bare = empty_state(frame_id, self.frame)
        try:
            data = read_frame_part(frame_id, self.parts)
            described = data.section("frame")
            shape = recorded_shape(described)
        except UNREADABLE as error:
            self.problems.append(f"The work on this frame cannot be read, so the frame is opened without it: {error}")
            return bare
        if shape != self.frame.shape:
            height, width = self.frame.shape
            self.problems.append(
                f"The frame has {width} x {height} pixels, but the work was done on {shape[1]} x {shape[0]}: the frame "
                "is opened without it."
            )
            return bare
        self.same_depth = described.values.get("measured") == measured_sha256(self.frame)
        frame = self._read_or_report(
            "The frame's invalid mask, ground truth, guide and depth of neighbours are",
            lambda: self._frame_with_layers(data),
            self.frame,
        )
        labels = self._read_or_report("The blocks and their results are", lambda: self._labels(data, "labels"), None)
        notes = self._read_or_report(
            "Names and other settings of blocks are", lambda: self._notes(data.section("notes")), BlockNotes()
        )
        results, extrapolation = {}, None
        if labels is not None:
            results = self._results(data, data)
            extrapolation = self._read_or_report(
                "The extrapolated depth is", lambda: self._extrapolation(data, "extrapolation"), None
            )
        state = FrameState(
            id=frame_id,
            frame=frame,
            labels=bare.labels if labels is None else labels,
            notes=notes,
            common=self._read_or_report(
                "Parameters are", lambda: Parameters.from_dict(data.get("parameters", dict)), preset()
            ),
            results=results,
            extrapolation=extrapolation,
            by_hand=self._read_or_report("Depth by hand is", lambda: self._by_hand(data), None),
            runs=self._run_history(data),
            **self._plain_fields(data),
        )
        self._read_or_report("Colour and depth of the frame are", lambda: self._register_frame_parts(described), None)
        return state

    def _plain_fields(self, data: Section) -> dict[str, Any]:
        """Decode the fields without arrays."""
        readers: dict[str, Callable[[], Any]] = {
            "compared": lambda: data.get("compared", tuple[int, ...]),
            "next_number": lambda: data.get("next_number", int),
            "extrapolate": lambda: data.get("extrapolate", bool),
            "own_parameters": lambda: data.get("own_parameters", bool),
            "note": lambda: data.get("note", str),
            "done": lambda: data.get("done", bool),
            "to_check": lambda: data.get("to_check", frozenset[int]),
            "ignored": lambda: data.get("ignored", tuple[IgnoredPlace, ...]),
            "selected": lambda: data.get("selected", tuple[int, ...]),
            "looked": lambda: inspection_of(data.section("looked")),
            "view": lambda: data.get("view", dict),
        }
        return self._readable_fields(readers)

    def _readable_fields(self, readers: dict[str, Callable[[], Any]]) -> dict[str, Any]:
        """Return the readable fields by name; fields that cannot be read are left out."""
        found = {}
        for name, read in readers.items():
            try:
                found[name] = read()
            except UNREADABLE as error:
                self.problems.append(f"The frame's {name.replace('_', ' ')!r} is lost: {error}")
        return found

    def _read_or_report(self, what: str, read: Callable[[], T], default: T) -> T:
        """Return what `read` returns; if it fails, the default, and report the problem."""
        try:
            return read()
        except UNREADABLE as error:
            self.problems.append(f"{what} lost: {error}")
            return default

    def _content(self, name: str) -> bytes:
        content = array_content(self.parts, name)
        self.names.add(name)
        return content

    def _array(self, data: Section, key: str, read: Callable[[str, bytes, tuple[int, int]], Any]) -> Any:
        """Read an array; all references to the same part share one array."""
        name = data.get(key, str, None)
        if name is None:
            return None
        if (name, read) not in self.arrays:
            array = read(name, self._content(name), self.frame.shape)
            self.arrays[name, read] = array
            self.origins.append((array, name))
        return self.arrays[name, read]

    def _labels(self, data: Section, key: str) -> NDArray[np.int32] | None:
        labels: NDArray[np.int32] | None = self._array(data, key, labels_from_bytes)
        return labels

    def _mask(self, data: Section, key: str) -> NDArray[np.bool_] | None:
        mask: NDArray[np.bool_] | None = self._array(data, key, mask_from_bytes)
        return mask

    def _frame_with_layers(self, data: Section) -> RGBDFrame:
        """Return the frame with the invalid mask, ground truth, guide and depth of neighbours of `data`; equal ones
        share one frame."""
        layers = "invalid_mask", "ground_truth", "guide", "neighbours"
        key = json.dumps([data.values.get(name) for name in layers], sort_keys=True)
        if key not in self.frames:
            mask = self._read_or_report("The invalid mask is", lambda: self._mask(data, "invalid_mask"), None)
            frame = self._read_or_report("The ground truth is", lambda: self._with_ground_truth(data), self.frame)
            guide = self._read_or_report("The guide is", lambda: self._guide_of(data), None)
            neighbours = self._read_or_report("Depth of neighbours is", lambda: self._neighbours_of(data), None)
            seen = frame.with_invalid_mask(mask).with_guide(guide).with_neighbours(neighbours)
            if seen.ground_truth is not None and seen.inputs is None:
                self.origins.append((seen.ground_truth, data.section("ground_truth").get("array", str)))
            self.frames[key] = seen
        return self.frames[key]

    def _guide_of(self, data: Section) -> Guide | None:
        """Return the guide of `data`; equal ones share one guide."""
        if "guide" not in data.values:
            return None
        section = data.section("guide")
        key = json.dumps(section.values, sort_keys=True)
        if key not in self.guides:
            values, confidence = (self._array(section, name, _depth) for name in ("values", "confidence"))
            guide = Guide(values, confidence, section.get("path", str, None))
            for array, name in ((guide.values, "values"), (guide.confidence, "confidence")):
                if array is not None:
                    self.origins.append((array, section.get(name, str)))
            self.guides[key] = guide
        return self.guides[key]

    def _neighbours_of(self, data: Section) -> NeighbourDepth | None:
        """Return the depth of neighbours of `data`; equal ones share one object."""
        if "neighbours" not in data.values:
            return None
        section = data.section("neighbours")
        key = json.dumps(section.values, sort_keys=True)
        if key not in self.neighbours:
            used = tuple(one.neighbour() for one in section.get("used", tuple[RecordedNeighbour, ...]))
            name, shape = section.get("layers", str), (len(used), *self.frame.shape)
            layers = Npz(name, self._content(name)).array("depth", np.float32, shape)
            self.neighbours[key] = NeighbourDepth(layers, used)
            self.origins.append((layers, name))
        return self.neighbours[key]

    def _by_hand(self, data: Section) -> DepthByHand | None:
        """Return depth by hand of `data`; equal ones share one object."""
        if "by_hand" not in data.values:
            return None
        section = data.section("by_hand")
        key = json.dumps(section.values, sort_keys=True)
        if key not in self.by_hands:
            depth, weight = self._array(section, "depth", _depth), section.get("weight", float)
            self.by_hands[key] = by_hand = DepthByHand(depth, weight)
            self.origins.append((by_hand.depth, section.get("depth", str)))
        return self.by_hands[key]

    def _register_frame_parts(self, described: Section) -> None:
        """Record the parts with the colour, depth and outside view of a frame that was not read from files."""
        if self.same_depth and "inputs" not in described.values:
            colour, depth = described.get("rgb", str), described.get("depth", str)
            self.names |= {colour, depth}
            self.origins.append((self.frame.rgb, colour))
            self.origins += [(frame.measured, depth) for frame in self.frames.values()]
        if "outside_view" in described.values and self.frame.outside_view is not None:
            outside = described.get("outside_view", str)
            self.names.add(outside)
            self.origins.append((self.frame.outside_view, outside))

    def _with_ground_truth(self, data: Section) -> RGBDFrame:
        """Return the frame with the ground truth of `data`."""
        if data.get("ground_truth", dict, None) is None:
            return self.frame if self.frame.ground_truth is None else self.frame.with_ground_truth(None)
        ground_truth = data.section("ground_truth")
        if "array" in ground_truth.values:
            return self.frame.with_ground_truth(self._array(ground_truth, "array", _depth))
        file = data.get("ground_truth", GroundTruthFile)
        known = None if self.frame.inputs is None else self.frame.inputs.ground_truth
        if self.frame.ground_truth is not None and known and (known.sha256, known.units) == (file.sha256, file.units):
            return self.frame
        try:
            return with_ground_truth(self.frame, file, self.parts, self.places)
        except InputError as error:
            self.problems.append(f"The ground truth is not available: {error}")
            return self.frame.with_ground_truth(None, file)  # the file stays listed and may be available the next time

    def _notes(self, data: Section) -> BlockNotes:
        readers: dict[str, Callable[[], Any]] = {
            "infos": lambda: data.get("infos", dict[int, BlockInfo]),
            "own": lambda: own_values_of(data),
            "drawn": lambda: self._mask(data, "drawn"),
            "extraction": lambda: self._extraction(data),
            "network": lambda: data.get("network", str, None),
            "extracted": lambda: self._labels(data, "extracted"),
            "kept": lambda: data.get("kept", frozenset[int]),
            "handmade": lambda: data.get("handmade", frozenset[int]),
            "propagated_from": lambda: data.get("propagated_from", str),
            "reasons": lambda: data.get("reasons", dict[int, str]),
        }
        return BlockNotes(**self._readable_fields(readers))

    def _extraction(self, data: Section) -> BlockParameters | None:
        values = data.get("extraction", dict, None)
        return None if values is None else BlockParameters.from_dict(values)

    def _results(self, data: Section, frame_part: Section) -> dict[int, BlockResult]:
        """Return the readable results by label."""
        none: list[tuple[int, str, int]] = []
        rows = self._read_or_report("Results of blocks are", lambda: result_rows(data, frame_part), none)
        results = {}
        for label, name, place in rows:
            found = self._pack(name)
            if 0 <= place < len(found):
                results[label] = found[place]
            elif found:
                self.problems.append(f"The result of block {label} is lost: its part does not contain it.")
        return results

    def _pack(self, name: str) -> list[BlockResult]:
        if name not in self.packs:
            self.packs[name] = self._read_or_report("Results of some blocks are", lambda: self._unpacked(name), [])
            self.origins += [(result, (name, place)) for place, result in enumerate(self.packs[name])]
        return self.packs[name]

    def _unpacked(self, name: str) -> list[BlockResult]:
        if not self.same_depth:
            raise InputError("the frame's depth has changed since. Run the blocks again.")
        return unpack_results(name, self._content(name), self.frame.measured)

    def _extrapolation(self, data: Section, key: str) -> Extrapolation | None:
        if data.get(key, dict, None) is None:
            return None
        extrapolation = data.section(key)
        name, count = extrapolation.get("array", str), extrapolation.get("count", int)
        height, width = self.frame.shape
        if not 0 <= count <= height * width:
            raise FormatError(f"{count} extrapolated pixels are more than the frame has.")
        packed = Npz(name, self._content(name))
        pixels = np.cumsum(packed.array("steps", np.int32, (count,)), dtype=np.int64)
        if count and not 0 <= pixels.min() <= pixels.max() < height * width:
            raise FormatError("The extrapolated pixels lie outside the frame.")
        depth = packed.array("depth", np.float32, (count,))
        depth.setflags(write=False)
        self.origins.append((depth, name))
        return Extrapolation(
            pixels, depth, extrapolation.get("notes", tuple[str, ...]), extrapolation.get("network", str, None)
        )

    def _run_history(self, data: Section) -> tuple[StoredRun, ...]:
        none: list[dict[str, Any]] = []
        rows = self._read_or_report("The run history is", lambda: data.items("runs", dict), none)
        runs = []
        for row in rows:
            name = str(row.get("name", row.get("number", "?")))
            try:
                runs.append(self._kept(Section("stored run", row), data))
            except UNREADABLE as error:
                self.problems.append(f"The stored run {name!r:.60} is lost: {error}")
        return tuple(runs)

    def _kept(self, kept: Section, data: Section) -> StoredRun:
        return StoredRun(
            number=kept.get("number", int),
            name=kept.get("name", str),
            run=self._run(kept.section("run")),
            results=self._results(kept, data),
            seconds=kept.get("seconds", float),
            colour=kept.get("colour", Colour),
            note=kept.get("note", str),
            when=kept.get("when", datetime.datetime),
            done=kept.get("done", frozenset[int]),
            how=kept.get("how", str),
            extrapolation=self._read_or_report(
                "The extrapolated depth of a stored run is", lambda: self._extrapolation(kept, "extrapolation"), None
            ),
            ground_truth_error=number_or_none(kept, "ground_truth_error"),
            hold_out_error=number_or_none(kept, "hold_out_error"),
            expected_error=number_or_none(kept, "expected_error"),
            hold_out_test=kept.get("hold_out_test", HoldOutTest, None),
        )

    def _run(self, data: Section) -> Run:
        only = data.get("only", list, None)
        labels = self._labels(data, "blocks")
        if labels is None:
            raise FormatError("It has no blocks.")
        parameters = Parameters.from_dict(data.get("parameters", dict))
        own = own_values_of(data)
        return Run(
            self._frame_with_layers(data),
            labels,
            parameters,
            {label: parameters.replace(**values) for label, values in own.items()},
            only=None if only is None else selected_labels(data),
            extrapolate=data.get("extrapolate", bool),
            extraction=self._extraction(data),
            edited=data.get("edited", bool),
            network=data.get("network", str, None),
            notes=data.get("notes", tuple[str, ...]),
            drawn=self._mask(data, "drawn"),
            by_hand=self._by_hand(data),
        )


def _depth(name: str, content: bytes, shape: tuple[int, int]) -> NDArray[np.float32]:
    return Npz(name, content).array("depth", np.float32, shape)

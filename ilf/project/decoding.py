"""Decoding a frame's state from its parts: whole, or not at all."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.named_places import NotAllowed
from .._runtime.schema import converted
from ..data.by_hand import DepthByHand
from ..data.camera import CameraIntrinsics
from ..data.frame import GroundTruthFile, RGBDFrame
from ..data.guide import Guide
from ..data.neighbours import NeighbourDepth
from ..data.parameters import Parameters
from ..data.results import BlockResult
from ..errors import FormatError, InputError
from ..run.record_file import parsed_inputs
from ..run.run import Run
from .archive import Parts
from .encoding import Origin, measured_sha256
from .frame_state import BlockNotes, FrameState, InspectionState, OwnValues
from .packing import Npz, colour_from_bytes, labels_from_bytes, mask_from_bytes
from .result_packs import unpack_results
from .run_history import Extrapolation, StoredRun
from .sources import ChangedSource, MissingSource, Places, load_inputs, with_ground_truth
from .state_json import (
    UNREADABLE,
    ByHandJson,
    ExtrapolationJson,
    GuideJson,
    InspectionJson,
    LayersJson,
    NeighboursJson,
    NotesJson,
    RunJson,
    StateJson,
    StoredRunJson,
    array_content,
    error_or_none,
    read_frame_part,
)

T = TypeVar("T")


class UnreadableFrame(InputError):
    """The stored state of a frame is damaged, or of another version."""


@dataclass(frozen=True, eq=False)
class Decoded:
    """A frame's state as it was stored.

    Attributes
    ----------
    state : FrameState
    problems : tuple of str
        Why its ground truth is not available; one sentence each. Its file stays listed.
    origins : tuple
        Arrays and results with the part that each was read from, for `Encoder.learn`.
    names : frozenset of str
        All parts with arrays that were read.
    """

    state: FrameState
    problems: tuple[str, ...] = ()
    origins: tuple[tuple[object, Origin], ...] = ()
    names: frozenset[str] = frozenset()


def load_state(frame_id: str, parts: Parts, places: Places | None = None) -> Decoded:
    """Load a frame, from its files or from the project, with all work on it.

    Parameters
    ----------
    frame_id : str
    parts : Parts
        Store with `frames/<id>.json` and the parts that it refers to.
    places : Places, optional
        Possible locations of its files.

    Raises
    ------
    MissingSource, ChangedSource
        If one of its files was not found, or has changed.
    UnreadableFrame
        If any part of its state is missing, damaged or of another version.
    """
    try:
        decoding = _Decoding(read_frame_part(frame_id, parts), parts, places)
        state = decoding.state(frame_id)
    except (MissingSource, ChangedSource, NotAllowed):
        raise
    except UNREADABLE as error:
        raise UnreadableFrame(f"The work on this frame cannot be read: {error}") from error
    return Decoded(state, tuple(dict.fromkeys(decoding.problems)), tuple(decoding.origins), frozenset(decoding.names))


class _Decoding:
    """Decodes one state."""

    def __init__(self, stored: StateJson, parts: Parts, places: Places | None) -> None:
        self.stored, self.parts, self.places = stored, parts, places
        self.problems: list[str] = []
        self.origins: list[tuple[object, Origin]] = []
        self.names: set[str] = set()
        self.made: dict[tuple[object, ...], Any] = {}
        self.shape = stored.frame.shape
        self.frame = self._frame()
        if self.frame.shape != self.shape:
            height, width = self.frame.shape
            raise FormatError(
                f"The frame has {width} x {height} pixels, but the work was done on {self.shape[1]} x {self.shape[0]}."
            )

    def state(self, frame_id: str) -> FrameState:
        """Decode the whole state."""
        stored = self.stored
        return FrameState(
            id=frame_id,
            frame=self._with_layers(stored),
            labels=self._array(stored.labels, labels_from_bytes),
            notes=self._notes(stored.notes),
            common=stored.parameters,
            results=self._results(stored.results),
            extrapolation=self._extrapolation(stored.extrapolation),
            runs=tuple(self._stored_run(run) for run in stored.runs),
            compared=stored.compared,
            next_number=stored.next_number,
            by_hand=self._by_hand(stored.by_hand),
            extrapolate=stored.extrapolate,
            own_parameters=stored.own_parameters,
            note=stored.note,
            done=stored.done,
            to_check=stored.to_check,
            ignored=stored.ignored,
            selected=stored.selected,
            looked=_inspection(stored.looked),
            view=stored.view,
        )

    def _frame(self) -> RGBDFrame:
        """Load the frame from its files, or from its stored arrays."""
        stored = self.stored.frame
        camera = None if stored.intrinsics is None else CameraIntrinsics(*stored.intrinsics)
        if stored.inputs is not None:
            frame = load_inputs(parsed_inputs(stored.inputs), stored.name, camera, self.parts, self.places)
        elif stored.rgb is None or stored.depth is None:
            raise FormatError("The frame has neither files nor arrays.")
        else:
            colour, depth = self._array(stored.rgb, colour_from_bytes), self._array(stored.depth, _depth)
            frame = RGBDFrame(colour, depth, camera, stored.name)
            self.origins.append((frame.rgb, stored.rgb))
        if stored.pose is not None:
            frame = dataclasses.replace(frame, pose=np.array(stored.pose))
        if stored.outside_view is not None:
            outside = self._array(stored.outside_view, mask_from_bytes)
            frame = dataclasses.replace(frame, outside_view=outside)
            self.origins.append((frame.outside_view, stored.outside_view))
        return frame

    # Arrays and what consists of them: equal references share one object.

    def _shared(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        if key not in self.made:
            self.made[key] = make()
        found: T = self.made[key]
        return found

    def _content(self, name: str) -> bytes:
        self.names.add(name)
        return array_content(self.parts, name)

    def _array(self, name: str, read: Callable[[str, bytes, tuple[int, int]], T]) -> T:
        def make() -> T:
            array = read(name, self._content(name), self.shape)
            self.origins.append((array, name))
            return array

        return self._shared((read, name), make)

    def _array_or_none(self, name: str | None, read: Callable[[str, bytes, tuple[int, int]], T]) -> T | None:
        return None if name is None else self._array(name, read)

    def _with_layers(self, stored: LayersJson) -> RGBDFrame:
        """Return the frame with the invalid mask, ground truth, guide and depth of neighbours of a state or run."""
        layers = stored.invalid_mask, stored.ground_truth, stored.guide, stored.neighbours

        def make() -> RGBDFrame:
            frame = self._with_ground_truth(stored.ground_truth)
            frame = frame.with_invalid_mask(self._array_or_none(stored.invalid_mask, mask_from_bytes))
            frame = frame.with_guide(self._guide(stored.guide)).with_neighbours(self._neighbours(stored.neighbours))
            truth = stored.ground_truth
            if truth is not None and "array" in truth:
                self.origins.append((frame.ground_truth, truth["array"]))
            if self.stored.frame.inputs is None and self.stored.frame.depth is not None:
                self.origins.append((frame.measured, self.stored.frame.depth))
            return frame

        return self._shared(("frame", msgspec.json.encode(layers)), make)

    def _with_ground_truth(self, stored: dict[str, Any] | None) -> RGBDFrame:
        """Return the frame with the stored ground truth."""
        if stored is None:
            return self.frame if self.frame.ground_truth is None else self.frame.with_ground_truth(None)
        if "array" in stored:
            return self.frame.with_ground_truth(self._array(converted(stored["array"], str, "ground truth"), _depth))
        file = converted(stored, GroundTruthFile, "ground truth")
        try:
            return with_ground_truth(self.frame, file, self.parts, self.places)
        except InputError as error:
            self.problems.append(f"The ground truth is not available: {error}")
            return self.frame.with_ground_truth(None, file)  # the file stays listed and may be available the next time

    def _guide(self, stored: GuideJson | None) -> Guide | None:
        if stored is None:
            return None

        def make() -> Guide:
            confidence = self._array_or_none(stored.confidence, _depth)
            guide = Guide(self._array(stored.values, _depth), confidence, stored.path)
            self.origins.append((guide.values, stored.values))
            if stored.confidence is not None:
                self.origins.append((guide.confidence, stored.confidence))
            return guide

        return self._shared(("guide", stored.values, stored.confidence, stored.path), make)

    def _neighbours(self, stored: NeighboursJson | None) -> NeighbourDepth | None:
        if stored is None:
            return None

        def make() -> NeighbourDepth:
            used = tuple(one.neighbour() for one in stored.used)
            content = self._content(stored.layers)
            layers = Npz(stored.layers, content).array("depth", np.float32, (len(used), *self.shape))
            self.origins.append((layers, stored.layers))
            return NeighbourDepth(layers, used)

        return self._shared(("neighbours", msgspec.json.encode(stored)), make)

    def _by_hand(self, stored: ByHandJson | None) -> DepthByHand | None:
        if stored is None:
            return None

        def make() -> DepthByHand:
            by_hand = DepthByHand(self._array(stored.depth, _depth), stored.weight)
            self.origins.append((by_hand.depth, stored.depth))
            return by_hand

        return self._shared(("by_hand", stored.depth, stored.weight), make)

    # Blocks, results and runs.

    def _notes(self, stored: NotesJson) -> BlockNotes:
        return BlockNotes(
            stored.infos,
            _own_values(stored.own),
            self._array_or_none(stored.drawn, mask_from_bytes),
            stored.extraction,
            stored.network,
            self._array_or_none(stored.extracted, labels_from_bytes),
            stored.kept,
            stored.handmade,
            stored.propagated_from,
            stored.reasons,
        )

    def _results(self, rows: list[tuple[int, int, int]]) -> dict[int, BlockResult]:
        """Return the results by label."""
        results, packs = {}, self.stored.packs
        for label, pack, place in rows:
            found = self._pack(packs[pack]) if 0 <= pack < len(packs) else []
            if not 0 <= place < len(found):
                raise FormatError(f"No part contains the result of block {label}.")
            results[label] = found[place]
        return results

    def _pack(self, name: str) -> list[BlockResult]:
        def make() -> list[BlockResult]:
            if self.stored.frame.measured != measured_sha256(self.frame):
                raise InputError("The frame's depth has changed since.")
            results = unpack_results(name, self._content(name), self.frame.measured)
            self.origins += [(result, (name, place)) for place, result in enumerate(results)]
            return results

        return self._shared(("pack", name), make)

    def _extrapolation(self, stored: ExtrapolationJson | None) -> Extrapolation | None:
        if stored is None:
            return None
        name, count, size = stored.array, stored.count, self.shape[0] * self.shape[1]
        if not 0 <= count <= size:
            raise FormatError(f"{count} extrapolated pixels are more than the frame has.")
        packed = Npz(name, self._content(name))
        pixels = np.cumsum(packed.array("steps", np.int32, (count,)), dtype=np.int64)
        if count and not 0 <= pixels.min() <= pixels.max() < size:
            raise FormatError("The extrapolated pixels lie outside the frame.")
        depth: NDArray[np.float32] = packed.array("depth", np.float32, (count,))
        depth.setflags(write=False)
        self.origins.append((depth, name))
        return Extrapolation(pixels, depth, stored.notes, stored.network)

    def _stored_run(self, stored: StoredRunJson) -> StoredRun:
        return StoredRun(
            number=stored.number,
            name=stored.name,
            run=self._run(stored.run),
            results=self._results(stored.results),
            seconds=stored.seconds,
            colour=stored.colour,
            note=stored.note,
            when=stored.when,
            done=stored.done,
            how=stored.how,
            extrapolation=self._extrapolation(stored.extrapolation),
            ground_truth_error=error_or_none(stored.ground_truth_error),
            hold_out_error=error_or_none(stored.hold_out_error),
            expected_error=error_or_none(stored.expected_error),
            hold_out_test=stored.hold_out_test,
        )

    def _run(self, stored: RunJson) -> Run:
        parameters, only = stored.parameters, stored.only
        return Run(
            self._with_layers(stored),
            self._array(stored.blocks, labels_from_bytes),
            parameters,
            {label: parameters.replace(**values) for label, values in _own_values(stored.own).items()},
            only=only if only is None or stored.in_order else frozenset(only),
            extrapolate=stored.extrapolate,
            extraction=stored.extraction,
            edited=stored.edited,
            network=stored.network,
            notes=stored.notes,
            drawn=self._array_or_none(stored.drawn, mask_from_bytes),
            by_hand=self._by_hand(stored.by_hand),
        )


def _depth(name: str, content: bytes, shape: tuple[int, int]) -> NDArray[np.float32]:
    return Npz(name, content).array("depth", np.float32, shape)


def _own_values(own: dict[int, dict[str, Any]]) -> dict[int, OwnValues]:
    """Return the checked own parameters of blocks, by label."""
    checked = {label: Parameters().replace(**values).to_dict() for label, values in own.items()}
    return {label: {name: checked[label][name] for name in values} for label, values in own.items()}


def _inspection(stored: InspectionJson) -> InspectionState:
    region = stored.region
    box = None if region is None else (slice(*region[0]), slice(*region[1]))
    return InspectionState(stored.line, box, stored.measurements)

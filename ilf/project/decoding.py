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
from ..data.blocks import Blocks, OwnValues
from ..data.by_hand import DepthByHand
from ..data.camera import Camera
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
from .frame_state import FrameState, InspectionState
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
    RunJson,
    StateJson,
    StoredRunJson,
    array_content,
    error_or_none,
    read_frame_part,
)

T = TypeVar("T")
Stored = TypeVar("Stored")


class UnreadableFrame(InputError):
    """The stored state of a frame is damaged, or of another version."""


@dataclass(frozen=True, eq=False)
class Decoded:
    """A frame's state as it was stored.

    Attributes
    ----------
    state : FrameState
    problems : tuple of str
        Why its ground truth, whose file stays listed, or its results are not available; one sentence each.
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
        self.made: dict[tuple[str, bytes], Any] = {}
        self.shape = stored.frame.shape
        self.frame = self._frame()
        if self.frame.shape != self.shape:
            height, width = self.frame.shape
            raise FormatError(
                f"The frame has {width} x {height} pixels, but the work was done on {self.shape[1]} x {self.shape[0]}."
            )
        if stored.packs and stored.frame.measured != measured_sha256(self.frame):
            # as where another version reads the same files differently; blocks and parameters still fit
            self.problems.append("Its results are left out, because the frame's depth is another now. Run it again.")
            self.stored = msgspec.structs.replace(stored, results=[], extrapolation=None, runs=(), compared=())

    def state(self, frame_id: str) -> FrameState:
        """Decode the whole state."""
        stored = self.stored
        return FrameState(
            id=frame_id,
            frame=self._with_layers(stored),
            blocks=self._blocks(stored),
            common=stored.parameters,
            results=self._results(stored.results),
            extrapolation=self._once_or_none(stored.extrapolation, self._extrapolation),
            runs=tuple(self._stored_run(run) for run in stored.runs),
            compared=stored.compared,
            next_number=stored.next_number,
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
        camera = None if stored.intrinsics is None else Camera(*stored.intrinsics)
        if stored.inputs is not None:
            frame = load_inputs(parsed_inputs(stored.inputs), stored.name, camera, self.parts, self.places)
        elif stored.rgb is None or stored.depth is None:
            raise FormatError("The frame has neither files nor arrays.")
        else:
            colour = colour_from_bytes(stored.rgb, self._content(stored.rgb), self.shape)
            frame = RGBDFrame(colour, self._depth(stored.depth), camera, stored.name)
            self._known(frame.rgb, stored.rgb)
        if stored.pose is not None:
            frame = dataclasses.replace(frame, pose=np.array(stored.pose))
        if stored.outside_view is not None:
            frame = dataclasses.replace(frame, outside_view=self._mask(stored.outside_view))
            self._known(frame.outside_view, stored.outside_view)
        return frame

    # Arrays and what consists of them: equal references share one object.

    def _once(self, stored: Stored, make: Callable[[Stored], T]) -> T:
        """Return what a method makes of a stored value; equal values share one object."""
        key = make.__name__, msgspec.json.encode(stored)
        if key not in self.made:
            self.made[key] = make(stored)
        found: T = self.made[key]
        return found

    def _once_or_none(self, stored: Stored | None, make: Callable[[Stored], T]) -> T | None:
        return None if stored is None else self._once(stored, make)

    def _content(self, name: str) -> bytes:
        self.names.add(name)
        return array_content(self.parts, name)

    def _known(self, array: T, name: str) -> T:
        """Return an array of a part, and note that it comes from there."""
        self.origins.append((array, name))
        return array

    def _labels(self, name: str) -> NDArray[np.int32]:
        return self._known(labels_from_bytes(name, self._content(name), self.shape), name)

    def _mask(self, name: str) -> NDArray[np.bool_]:
        return self._known(mask_from_bytes(name, self._content(name), self.shape), name)

    def _depth(self, name: str) -> NDArray[np.float32]:
        return Npz(name, self._content(name)).array("depth", np.float32, self.shape)

    def _with_layers(self, stored: LayersJson) -> RGBDFrame:
        """Return the frame with the invalid mask, ground truth, guide and depth of neighbours of a state or run."""
        layers = LayersJson(
            invalid_mask=stored.invalid_mask,
            ground_truth=stored.ground_truth,
            guide=stored.guide,
            neighbours=stored.neighbours,
        )
        return self._once(layers, self._layered_frame)

    def _layered_frame(self, stored: LayersJson) -> RGBDFrame:
        frame = self._with_ground_truth(stored.ground_truth)
        frame = frame.with_invalid_mask(self._once_or_none(stored.invalid_mask, self._mask))
        frame = frame.with_guide(self._once_or_none(stored.guide, self._guide))
        frame = frame.with_neighbours(self._once_or_none(stored.neighbours, self._neighbours))
        if stored.ground_truth is not None and "array" in stored.ground_truth:
            self._known(frame.ground_truth, stored.ground_truth["array"])
        if self.stored.frame.inputs is None and self.stored.frame.depth is not None:
            self._known(frame.measured, self.stored.frame.depth)
        return frame

    def _with_ground_truth(self, stored: dict[str, Any] | None) -> RGBDFrame:
        """Return the frame with the stored ground truth."""
        if stored is None:
            return self.frame if self.frame.ground_truth is None else self.frame.with_ground_truth(None)
        if "array" in stored:
            name = converted(stored["array"], str, "ground truth")
            return self.frame.with_ground_truth(self._once(name, self._depth))
        file = converted(stored, GroundTruthFile, "ground truth")
        try:
            return with_ground_truth(self.frame, file, self.parts, self.places)
        except InputError as error:
            self.problems.append(f"The ground truth is not available: {error}")
            return self.frame.with_ground_truth(None, file)  # the file stays listed and may be available the next time

    def _guide(self, stored: GuideJson) -> Guide:
        confidence = None if stored.confidence is None else self._depth(stored.confidence)
        guide = Guide(self._depth(stored.values), confidence, stored.path)
        self._known(guide.values, stored.values)
        if stored.confidence is not None:
            self._known(guide.confidence, stored.confidence)
        return guide

    def _neighbours(self, stored: NeighboursJson) -> NeighbourDepth:
        used = tuple(one.neighbour() for one in stored.used)
        packed, shape = Npz(stored.layers, self._content(stored.layers)), (len(used), *self.shape)
        layers = self._known(packed.array("depth", np.float32, shape), stored.layers)
        return NeighbourDepth(layers, used)

    def _by_hand(self, stored: ByHandJson) -> DepthByHand:
        by_hand = DepthByHand(self._depth(stored.depth), stored.weight)
        self._known(by_hand.depth, stored.depth)
        return by_hand

    # Blocks, results and runs.

    def _blocks(self, state: StateJson) -> Blocks:
        stored = state.notes
        return Blocks(
            self._once(state.labels, self._labels),
            stored.infos,
            _own_values(stored.own),
            self._once_or_none(stored.drawn, self._mask),
            self._once_or_none(state.by_hand, self._by_hand),
            stored.extraction,
            stored.network,
            self._once_or_none(stored.extracted, self._labels),
            stored.kept,
            stored.handmade,
            stored.propagated_from,
            stored.reasons,
            stored.notes,
        )

    def _results(self, rows: list[tuple[int, int, int]]) -> dict[int, BlockResult]:
        """Return the results by label."""
        results, packs = {}, self.stored.packs
        for label, pack, place in rows:
            found = self._once(packs[pack], self._pack) if 0 <= pack < len(packs) else []
            if not 0 <= place < len(found):
                raise FormatError(f"No part contains the result of block {label}.")
            results[label] = found[place]
        return results

    def _pack(self, name: str) -> list[BlockResult]:
        results = unpack_results(name, self._content(name), self.frame.measured)
        self.origins += [(result, (name, place)) for place, result in enumerate(results)]
        return results

    def _extrapolation(self, stored: ExtrapolationJson) -> Extrapolation:
        name, count, size = stored.array, stored.count, self.shape[0] * self.shape[1]
        if not 0 <= count <= size:
            raise FormatError(f"{count} extrapolated pixels are more than the frame has.")
        packed = Npz(name, self._content(name))
        pixels = np.cumsum(packed.array("steps", np.int32, (count,)), dtype=np.int64)
        if count and not 0 <= pixels.min() <= pixels.max() < size:
            raise FormatError("The extrapolated pixels lie outside the frame.")
        depth: NDArray[np.float32] = packed.array("depth", np.float32, (count,))
        depth.setflags(write=False)
        return Extrapolation(pixels, self._known(depth, name), stored.notes, stored.network)

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
            extrapolation=self._once_or_none(stored.extrapolation, self._extrapolation),
            ground_truth_error=error_or_none(stored.ground_truth_error),
            hold_out_error=error_or_none(stored.hold_out_error),
            expected_error=error_or_none(stored.expected_error),
            hold_out_test=stored.hold_out_test,
        )

    def _run(self, stored: RunJson) -> Run:
        parameters, only = stored.parameters, stored.only
        return Run(
            self._with_layers(stored),
            self._once(stored.blocks, self._labels),
            parameters,
            {label: parameters.replace(**values) for label, values in _own_values(stored.own).items()},
            only=only if only is None or stored.in_order else frozenset(only),
            extrapolate=stored.extrapolate,
            extraction=stored.extraction,
            edited=stored.edited,
            network=stored.network,
            notes=stored.notes,
            drawn=self._once_or_none(stored.drawn, self._mask),
            by_hand=self._once_or_none(stored.by_hand, self._by_hand),
        )


def _own_values(own: dict[int, dict[str, Any]]) -> dict[int, OwnValues]:
    """Return the checked own parameters of blocks, by label."""
    checked = {label: Parameters().replace(**values).to_dict() for label, values in own.items()}
    return {label: {name: checked[label][name] for name in values} for label, values in own.items()}


def _inspection(stored: InspectionJson) -> InspectionState:
    region = stored.region
    box = None if region is None else (slice(*region[0]), slice(*region[1]))
    return InspectionState(stored.line, box, stored.measurements)

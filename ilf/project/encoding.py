"""Encoding a frame's state as parts: its JSON, and the arrays that it refers to by name."""

from __future__ import annotations

import dataclasses
import weakref
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.schema import plain, strict_json
from ..data.blocks import Blocks
from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.guide import Guide
from ..data.neighbours import NeighbourDepth
from ..data.results import BlockResult
from ..run.record import RecordedNeighbour, array_sha256
from ..run.run import Run
from .frame_state import FrameState, InspectionState
from .packing import array_name, colour_to_bytes, labels_to_bytes, mask_to_bytes, npz
from .result_packs import PACK_BYTES, pack_results, packed_bytes
from .run_history import Extrapolation, StoredRun

SCHEMA = 1
"""Version of the format of a project's parts."""

PROGRAM = "ilf-studio"

Origin = str | tuple[str, int]
"""Where an object is stored: a part, or a part and an index in it."""


@dataclass(frozen=True)
class Encoded:
    """A frame's state as bytes.

    Attributes
    ----------
    frame : bytes
        Content of the part `frame_part(id)`.
    arrays : dict of str to bytes
        Parts that it refers to and that were not returned before.
    names : frozenset of str
        All parts that it refers to.
    """

    frame: bytes
    arrays: dict[str, bytes]
    names: frozenset[str]


def frame_part(frame_id: str) -> str:
    """Return the name of the part with a frame's state."""
    return f"frames/{frame_id}.json"


class Encoder:
    """Encodes states as parts, each array and result once. Not thread-safe.

    The caller stores the returned parts. Parts that were removed or could not be stored are returned again after
    `forget`.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((2, 3, 3), np.uint8), np.full((2, 3), 2.0))
    >>> from ilf.data.blocks import Blocks
    >>> state = FrameState("a1", frame, Blocks(np.ones((2, 3), np.int32)))
    >>> encoder = Encoder()
    >>> first, second = encoder.encode(state), encoder.encode(state)
    >>> len(first.arrays), len(second.arrays), first.names == second.names
    (3, 0, True)
    """

    def __init__(self) -> None:
        self._given: set[str] = set()
        self._known = Origins()

    def encode(self, state: FrameState) -> Encoded:
        """Encode a state.

        Parameters
        ----------
        state : FrameState
            Its arrays must not change meanwhile. Read-only arrays and results are remembered and not encoded again.
        """
        encoding = _Encoding(self._known)
        try:
            content = strict_json(encoding.state(state))
        except BaseException:
            self._known.forget(encoding.made.keys() - self._given)  # they are never returned
            raise
        arrays = {name: content for name, content in encoding.made.items() if name not in self._given}
        self._given.update(arrays)
        return Encoded(content, arrays, frozenset(encoding.names))

    def learn(self, origins: Iterable[tuple[object, Origin]], names: Collection[str]) -> None:
        """Register arrays and results that are stored in these parts already; see `Decoded.origins`."""
        for thing, origin in origins:
            self._known.put(thing, origin)
        self._given.update(names)

    def forget(self, names: Collection[str]) -> None:
        """Forget parts that are not stored (any more); their content is encoded and returned again when needed."""
        self._given.difference_update(names)
        self._known.forget(set(names))


class Origins:
    """Maps live objects, by identity, to the parts in which they are stored."""

    def __init__(self) -> None:
        self._of: dict[int, tuple[weakref.ref[Any], Origin]] = {}

    def get(self, thing: object) -> Origin | None:
        """Return where an object is stored; None if unknown."""
        found = self._of.get(id(thing))
        return None if found is None or found[0]() is not thing else found[1]

    def put(self, thing: object, origin: Origin) -> None:
        """Register where an object is stored; writable arrays are ignored."""
        if isinstance(thing, np.ndarray) and (thing.flags.writeable or thing.base is not None):
            return
        number = id(thing)
        self._of[number] = weakref.ref(thing, lambda gone: self._drop(number, gone)), origin

    def forget(self, names: Collection[str]) -> None:
        """Forget all objects in these parts."""
        for number, (_, origin) in self._of.copy().items():  # objects may be deleted meanwhile
            if (origin if isinstance(origin, str) else origin[0]) in names:
                self._of.pop(number, None)

    def _drop(self, number: int, gone: weakref.ref[Any]) -> None:
        if number in self._of and self._of[number][0] is gone:
            self._of.pop(number, None)


class _Encoding:
    """Encodes one state."""

    def __init__(self, known: Origins) -> None:
        self.known = known
        self.made: dict[str, bytes] = {}
        self.names: set[str] = set()
        self.packs: dict[str, int] = {}

    def state(self, state: FrameState) -> dict[str, Any]:
        """Encode a whole state for JSON."""
        frame, extrapolation = state.frame, state.extrapolation
        self._pack_results(_all_results(state), frame.measured)
        data = {
            "program": PROGRAM,
            "schema": SCHEMA,
            "id": state.id,
            "frame": self._frame(frame),
            **self._encode_layers(frame),
            **self._encode_by_hand(state.blocks.by_hand),
            "labels": self._array(state.blocks.labels, labels_to_bytes),
            "notes": self._notes(state.blocks),
            "parameters": state.common.to_dict(),
            "results": self._results(state.results),
            "extrapolation": None if extrapolation is None else self._extrapolation(extrapolation),
            "runs": [self._encode_run_history(run) for run in state.runs],
            "compared": list(state.compared),
            "next_number": state.next_number,
            "extrapolate": state.extrapolate,
            "own_parameters": state.own_parameters,
            "note": state.note,
            "done": state.done,
            "to_check": sorted(state.to_check),
            "ignored": [dataclasses.asdict(place) for place in state.ignored],
            "selected": list(state.selected),
            "looked": _encode_inspection(state.looked),
            "view": plain(state.view),
        }
        return data | {"packs": list(self.packs), "arrays": sorted(self.names)}

    def _frame(self, frame: RGBDFrame) -> dict[str, Any]:
        """Encode the frame: by its files, or by its arrays if it was not read from files."""
        camera, inputs = frame.intrinsics, frame.inputs
        data: dict[str, Any] = {
            "name": frame.name,
            "shape": list(frame.shape),
            "measured": measured_sha256(frame),
            "intrinsics": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy, camera.name],
        }
        if frame.pose is not None:
            data["pose"] = frame.pose.tolist()
        if frame.outside_view is not None and (inputs is None or inputs.frame is None):
            data["outside_view"] = self._array(frame.outside_view, mask_to_bytes)
        if inputs is not None:
            return data | {"inputs": dataclasses.asdict(inputs)}
        return data | {"rgb": self._array(frame.rgb, colour_to_bytes), "depth": self._array(frame.measured, _depth)}

    def _encode_layers(self, frame: RGBDFrame) -> dict[str, Any]:
        """Encode the frame's invalid mask, ground truth (as a file or an array), guide and depth of neighbours."""
        ground_truth: dict[str, Any] | None = None
        file = None if frame.inputs is None else frame.inputs.ground_truth
        if file is not None:
            ground_truth = dataclasses.asdict(file)
        elif frame.ground_truth is not None:
            ground_truth = {"array": self._array(frame.ground_truth, _depth)}
        seen: dict[str, Any] = {
            "invalid_mask": self._array(frame.invalid_mask, mask_to_bytes),
            "ground_truth": ground_truth,
        }
        if frame.guide is not None:
            seen["guide"] = self._encode_guide(frame.guide)
        if frame.neighbours is not None:
            seen["neighbours"] = self._encode_neighbours(frame.neighbours)
        return seen

    def _encode_guide(self, guide: Guide) -> dict[str, Any]:
        values, confidence = (self._array(array, _depth) for array in (guide.values, guide.confidence))
        return {"values": values, "confidence": confidence, "path": guide.path}

    def _encode_neighbours(self, depth: NeighbourDepth) -> dict[str, Any]:
        used = [dataclasses.asdict(RecordedNeighbour.of(one)) for one in depth.neighbours]
        return {"layers": self._array(depth.layers, _depth), "used": used}

    def _encode_by_hand(self, by_hand: DepthByHand | None) -> dict[str, Any]:
        """Encode depth by hand; nothing for none."""
        if by_hand is None:
            return {}
        return {"by_hand": {"depth": self._array(by_hand.depth, _depth), "weight": by_hand.weight}}

    def _notes(self, notes: Blocks) -> dict[str, Any]:
        return {
            "infos": {str(label): dataclasses.asdict(info) for label, info in notes.infos.items()},
            "own": {str(label): dict(own) for label, own in notes.own.items()},
            "drawn": self._array(notes.drawn, mask_to_bytes),
            "extraction": None if notes.extraction is None else notes.extraction.to_dict(),
            "network": notes.network,
            "extracted": self._array(notes.extracted, labels_to_bytes),
            "kept": sorted(notes.kept),
            "handmade": sorted(notes.handmade),
            "propagated_from": notes.propagated_from,
            "reasons": {str(label): reason for label, reason in notes.reasons.items()},
            "notes": list(notes.notes),
        }

    def _encode_run_history(self, kept: StoredRun) -> dict[str, Any]:
        test = kept.hold_out_test
        data = {
            "number": kept.number,
            "name": kept.name,
            "run": self._run(kept.run),
            "results": self._results(kept.results),
            "seconds": kept.seconds,
            "colour": list(kept.colour),
            "note": kept.note,
            "when": kept.when.isoformat(),
            "done": sorted(kept.done),
            "how": kept.how,
            "extrapolation": None if kept.extrapolation is None else self._extrapolation(kept.extrapolation),
            "hold_out_test": None if test is None else dataclasses.asdict(test),
        }
        errors = ("ground_truth_error", "hold_out_error", "expected_error")
        # an error that was not computed has no key; an undefined one is null
        return data | {name: getattr(kept, name) for name in errors if getattr(kept, name) is not None}

    def _run(self, run: Run) -> dict[str, Any]:
        return {
            **self._encode_layers(run.frame),
            "blocks": self._array(run.blocks, labels_to_bytes),
            "parameters": run.parameters.to_dict(),
            "own": {str(label): own.differences_from(run.parameters) for label, own in run.own.items()},
            "only": None if run.only is None else [int(label) for label in run.only],
            "in_order": isinstance(run.only, Sequence),
            "extrapolate": run.extrapolate,
            "extraction": None if run.extraction is None else run.extraction.to_dict(),
            "edited": run.edited,
            "network": run.network,
            "notes": list(run.notes),
            "drawn": self._array(run.drawn, mask_to_bytes),
            **self._encode_by_hand(run.by_hand),
        }

    def _extrapolation(self, extrapolation: Extrapolation) -> dict[str, Any]:
        # differences of successive indices are small numbers, which compress well
        arrays = {
            "steps": np.diff(extrapolation.pixels, prepend=np.int64(0)).astype(np.int32),
            "depth": extrapolation.depth,
        }
        name = self._array(extrapolation.depth, lambda _: (npz(arrays), ".npz"))
        return {
            "array": name,
            "count": len(extrapolation.pixels),
            "notes": list(extrapolation.notes),
            "network": extrapolation.network,
        }

    def _results(self, results: Mapping[int, BlockResult]) -> list[list[int]]:
        """Return label, index of the pack and index in it, for each result."""
        rows = []
        for label, result in results.items():
            origin = self.known.get(result)
            assert isinstance(origin, tuple)  # all results are packed by now
            name, place = origin
            self.names.add(name)
            rows.append([int(label), self.packs.setdefault(name, len(self.packs)), place])
        return rows

    def _pack_results(self, results: Sequence[BlockResult], measured: NDArray[np.float32]) -> None:
        """Pack the results that are in no part yet."""
        waiting: list[BlockResult] = []
        size = 0
        for result in results:
            if self.known.get(result) is None:
                waiting.append(result)
                size += packed_bytes(result)
                if size >= PACK_BYTES:
                    self._pack(waiting, measured)
                    waiting, size = [], 0
        if waiting:
            self._pack(waiting, measured)

    def _pack(self, results: Sequence[BlockResult], measured: NDArray[np.float32]) -> None:
        content = pack_results(results, measured)
        name = array_name(content, ".npz")
        self.made[name] = content
        for place, result in enumerate(results):
            self.known.put(result, (name, place))

    def _array(self, array: NDArray[Any] | None, to_bytes: Callable[[Any], tuple[bytes, str]]) -> str | None:
        """Return the name of an array's part; encode the array if it is not stored yet."""
        if array is None:
            return None
        name = self.known.get(array)
        if not isinstance(name, str):
            content, suffix = to_bytes(array)
            name = array_name(content, suffix)
            self.made[name] = content
            self.known.put(array, name)
        self.names.add(name)
        return name


def _all_results(state: FrameState) -> list[BlockResult]:
    """Return the present results and those of the run history, each once."""
    found = {id(result): result for result in state.results.values()}
    for kept in state.runs:
        found.update((id(result), result) for result in kept.results.values())
    return list(found.values())


def _depth(depth: NDArray[np.float32]) -> tuple[bytes, str]:
    return npz({"depth": depth}), ".npz"


@once_per_frame
def measured_sha256(frame: RGBDFrame) -> str:
    """Return the SHA-256 of a frame's measured depth, which stored results are relative to."""
    return array_sha256(frame.measured)


def _encode_inspection(looked: InspectionState) -> dict[str, Any]:
    region = looked.region
    return {
        "line": None if looked.line is None else [list(point) for point in looked.line],
        "region": None if region is None else [[side.start, side.stop] for side in region],
        "measurements": [[list(point) for point in line] for line in looked.measurements],
    }

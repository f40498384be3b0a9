"""Packs: results of many blocks in one part. Depth is stored only where it differs from the measured depth."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.schema import converted, strict_json
from ..data.by_hand import DepthByHand
from ..data.label_map import Block, Box
from ..data.parameters import BlockParameters, Parameters
from ..data.results import BlockResult, CompactHistory, EdgeAwareRecord, History, IterationRecord, PassBandRecord
from ..errors import FormatError
from ..run.record_file import parsed_outcome
from .packing import MAX_UNPACKED, Npz, npz

PACK_BYTES = 2**23
"""Size of masks and depth before compression [bytes] from which a new pack is begun."""

_RESULTS = "results.json"
_KINDS: dict[str, type[IterationRecord]] = {
    kind.__name__: kind for kind in (IterationRecord, EdgeAwareRecord, PassBandRecord)
}
_DTYPES = {"i": np.int64, "stage": np.int64, "cell": np.int64, "round": np.int64, "weighted": np.bool_}
"""Types of the record fields that are not float64."""
_PAIRS = {"radii"}


def pack_results(results: Sequence[BlockResult], measured: NDArray[np.float32]) -> bytes:
    """Encode results as the content of one part.

    Parameters
    ----------
    results : sequence of BlockResult
    measured : ndarray of float32, shape (H, W)
        The frame's `measured` depth [m], which is needed to unpack them.
    """
    parameters, edges = _UniqueValues(), _UniqueValues()
    entries: list[_Entry] = []
    masks, changed, depths, drawn, by_hand = [], [], [], [], []
    columns: dict[tuple[str, str], list[NDArray[Any]]] = {}
    for result in results:
        history = _compact(result.history)
        entries.append(
            _Entry(
                label=result.block.label,
                box=_ends(result.block.box),
                outcome=dataclasses.asdict(result.outcome),
                parameters=parameters.of(result.parameters.to_dict()),
                edges=None if result.edges is None else edges.of(result.edges.to_dict()),
                network=result.network,
                correction=result.correction,
                notes=tuple(result.notes),
                drawn=result.drawn is not None,
                by_hand=None if result.by_hand is None else result.by_hand.weight,
                history=None if history is None else (history.kind.__name__, len(history)),
            )
        )
        before = measured[result.block.box][result.block.mask]
        differs = _bits(result.depth) != _bits(before)
        masks.append(np.packbits(result.block.mask))
        changed.append(np.packbits(differs))
        depths.append(result.depth[differs])
        if result.drawn is not None:
            drawn.append(np.packbits(result.drawn))
        if result.by_hand is not None:
            by_hand.append(result.by_hand.depth)
        if history is not None:
            for name, column in history.columns.items():
                columns.setdefault((history.kind.__name__, name), []).append(column)
    arrays = {"masks": _joined(masks, np.uint8), "changed": _joined(changed, np.uint8)}
    arrays |= {"depth": _joined(depths, np.float32), "drawn": _joined(drawn, np.uint8)}
    if by_hand:
        arrays["by_hand"] = _joined(by_hand, np.float32)
    arrays |= {f"{kind}.{name}": _joined(parts, _dtype(name)) for (kind, name), parts in columns.items()}
    head = _Head(tuple(entries), tuple(parameters.values), tuple(edges.values))
    return npz(arrays, {_RESULTS: strict_json(dataclasses.asdict(head))})


def packed_bytes(result: BlockResult) -> int:
    """Estimate the size of a result in a pack before compression [bytes]."""
    return result.block.mask.size // 8 + result.depth.size * 4 + len(result.history) * 72


def unpack_results(name: str, content: bytes, measured: NDArray[np.float32]) -> list[BlockResult]:
    """Inverse of `pack_results`.

    Raises
    ------
    FormatError
        If the part is damaged, or belongs to another frame.
    """
    packed = Npz(name, content)
    try:
        head = converted(json.loads(packed.text(_RESULTS, MAX_UNPACKED // 8)), _Head, "list of results")
        return list(_unpacked(packed, head, measured))
    except FormatError:
        raise
    except (ArithmeticError, LookupError, TypeError, ValueError, RecursionError) as error:
        raise FormatError(f"The results in {name[:24]}... cannot be read ({error}).") from error


@dataclass(frozen=True)
class _Entry:
    """A result without its arrays; parameters are numbers in the lists of the head, `by_hand` the weight of its depth
    by hand, if any."""

    label: int
    box: tuple[int, int, int, int]
    outcome: dict[str, Any]
    parameters: int
    edges: int | None
    network: str | None
    correction: tuple[str, ...]
    notes: tuple[str, ...]
    drawn: bool
    history: tuple[str, int] | None
    by_hand: float | None


@dataclass(frozen=True)
class _Head:
    """The JSON of a pack."""

    results: tuple[_Entry, ...]
    parameters: tuple[dict[str, Any], ...]
    edges: tuple[dict[str, Any], ...]


class _UniqueValues:
    """A list of unique values, addressed by their numbers."""

    def __init__(self) -> None:
        self.values: list[dict[str, Any]] = []
        self._places: dict[tuple[object, ...], int] = {}

    def of(self, value: dict[str, Any]) -> int:
        key = tuple(value.items())
        if key not in self._places:
            self._places[key] = len(self.values)
            self.values.append(value)
        return self._places[key]


class _ArrayReader:
    """A sequential reader of an array."""

    def __init__(self, array: NDArray[Any]) -> None:
        self.array, self.place = array, 0

    def next(self, count: int) -> NDArray[Any]:
        self.place += count
        return self.array[self.place - count : self.place].copy()

    def bits(self, count: int) -> NDArray[np.bool_]:
        return np.unpackbits(self.next((count + 7) // 8), count=count).astype(bool)


def _unpacked(packed: Npz, head: _Head, measured: NDArray[np.float32]) -> list[BlockResult]:
    entries = head.results
    parameters = [Parameters.from_dict(values) for values in head.parameters]
    edges = [BlockParameters.from_dict(values) for values in head.edges]
    boxes = [_box(entry, measured.shape) for entry in entries]
    shapes = [(box[0].stop - box[0].start, box[1].stop - box[1].start) for box in boxes]
    if sum(h * w for h, w in shapes) > 8 * PACK_BYTES + measured.size:
        raise FormatError("The part contains more results than a part can.")
    mask_bits = _ArrayReader(packed.array("masks", np.uint8, (sum((h * w + 7) // 8 for h, w in shapes),)))
    masks = [mask_bits.bits(h * w).reshape(h, w) for h, w in shapes]
    pixels = [int(np.count_nonzero(mask)) for mask in masks]
    changed_bits = _ArrayReader(packed.array("changed", np.uint8, (sum((count + 7) // 8 for count in pixels),)))
    changed = [changed_bits.bits(count) for count in pixels]
    depth = _ArrayReader(packed.array("depth", np.float32, (sum(int(np.count_nonzero(one)) for one in changed),)))
    with_drawn = [entry.drawn for entry in entries]
    size = sum((count + 7) // 8 for count, has in zip(pixels, with_drawn, strict=True) if has)
    drawn = _ArrayReader(packed.array("drawn", np.uint8, (size,)))
    stated = sum(count for count, entry in zip(pixels, entries, strict=True) if entry.by_hand is not None)
    by_hand = _ArrayReader(packed.array("by_hand", np.float32, (stated,)) if stated else np.empty(0, np.float32))
    histories = _histories(packed, entries)
    results = []
    for place, entry in enumerate(entries):
        block = Block(entry.label, boxes[place], masks[place])
        found = measured[block.box][block.mask]
        found[changed[place]] = depth.next(int(np.count_nonzero(changed[place])))
        found.setflags(write=False)
        results.append(
            BlockResult(
                block,
                found,
                parsed_outcome(entry.outcome),
                histories[place],
                parameters[entry.parameters],
                entry.network,
                entry.notes,
                None if entry.edges is None else edges[entry.edges],
                drawn.bits(pixels[place]) if with_drawn[place] else None,
                entry.correction,
                by_hand=None if entry.by_hand is None else DepthByHand(by_hand.next(pixels[place]), entry.by_hand),
            )
        )
    return results


def _histories(packed: Npz, entries: Sequence[_Entry]) -> list[History]:
    """Read the histories of all results; the columns of each kind are stored one after the other."""
    lengths: dict[str, int] = {}
    stated = [entry.history for entry in entries]
    for kind, length in (history for history in stated if history is not None):
        if kind not in _KINDS or length < 1:
            raise FormatError(f"A history of kind {kind!r:.40} with {length} iterations is not valid.")
        lengths[kind] = lengths.get(kind, 0) + length
    columns = {
        kind: {
            field.name: _ArrayReader(
                packed.array(
                    f"{kind}.{field.name}", _dtype(field.name), (total, 2) if field.name in _PAIRS else (total,)
                )
            )
            for field in dataclasses.fields(_KINDS[kind])
        }
        for kind, total in lengths.items()
    }
    return [
        ()
        if history is None
        else CompactHistory.from_columns(
            _KINDS[history[0]], {name: column.next(history[1]) for name, column in columns[history[0]].items()}
        )
        for history in stated
    ]


def _compact(history: History) -> CompactHistory | None:
    if isinstance(history, CompactHistory):
        return history
    return CompactHistory(history) if history else None


def _ends(box: Box) -> tuple[int, int, int, int]:
    rows, columns = box
    return int(rows.start), int(rows.stop), int(columns.start), int(columns.stop)


def _box(entry: _Entry, shape: tuple[int, ...]) -> Box:
    top, bottom, left, right = entry.box
    if not (0 <= top < bottom <= shape[0] and 0 <= left < right <= shape[1]):
        raise FormatError("A result lies outside the frame.")
    return slice(top, bottom), slice(left, right)


def _dtype(name: str) -> type[np.generic]:
    return _DTYPES.get(name, np.float64)


def _joined(parts: Sequence[NDArray[Any]], dtype: type[np.generic]) -> NDArray[Any]:
    return np.concatenate(parts).astype(dtype, copy=False) if parts else np.empty(0, dtype)


def _bits(depth: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return the bits of depth values, in which NaN equals NaN."""
    return np.ascontiguousarray(depth).view(np.uint32)

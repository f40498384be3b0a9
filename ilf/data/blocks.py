"""Blocks: a frame's label map, an integer for each pixel, 0 for none; single blocks with their boxes and pixels; and
all that is said about the blocks."""

from __future__ import annotations

import colorsys
import itertools
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple, Self

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .arrays import check_shape, plain_array
from .by_hand import DepthByHand, as_by_hand
from .declarations import Value
from .frame import RGBDFrame, checked_mask, read_only
from .parameters import BlockParameters, Parameters
from .pixel_grids import nearest_values, odd_even_fill, strips

Box = tuple[slice, slice]
"""Rows and columns of a bounding box."""

_DENSE = 1 << 20
"""Maximum label up to which labels are assumed to be dense; above, most numbers are not labels of blocks."""


def grown(box: Box, by: int, shape: tuple[int, ...]) -> Box:
    """A box enlarged by a number of pixels on each side, clipped to the image."""
    rows, columns = box
    return (
        slice(max(rows.start - by, 0), min(rows.stop + by, shape[0])),
        slice(max(columns.start - by, 0), min(columns.stop + by, shape[1])),
    )


def within(inside: Box, outside: Box) -> Box:
    """Return a box relative to an enclosing box."""
    rows, columns = (slice(a.start - b.start, a.stop - b.start) for a, b in zip(inside, outside, strict=True))
    return rows, columns


def whole(shape: tuple[int, ...]) -> Box:
    """The box of a whole array."""
    return slice(0, shape[0]), slice(0, shape[1])


def union(one: Box, other: Box) -> Box:
    """Return the smallest box that encloses two boxes."""
    rows, columns = (slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(one, other, strict=True))
    return rows, columns


def bounds(mask: NDArray[np.bool_]) -> Box | None:
    """The bounding box of a mask; None if it is empty."""
    rows = np.flatnonzero(mask.any(axis=1))
    if rows.size == 0:
        return None
    columns = np.flatnonzero(mask[rows[0] : rows[-1] + 1].any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def moved(box: Box, down: int, right: int) -> Box:
    """A box moved by a number of pixels."""
    rows, columns = box
    return slice(rows.start + down, rows.stop + down), slice(columns.start + right, columns.stop + right)


def box_between(low: NDArray[np.floating], high: NDArray[np.floating], shape: tuple[int, ...]) -> Box | None:
    """The pixels from one point (x, y) to another, clipped to the image; None if there are none."""
    left, top = np.floor(np.maximum(low, 0)).astype(int).tolist()
    right, bottom = np.ceil(np.minimum(high, shape[1::-1])).astype(int).tolist()
    return (slice(top, bottom), slice(left, right)) if left < right and top < bottom else None


class Region(NamedTuple):
    """Pixels in a box (rows, columns) of the image, such as those that a brush covers."""

    box: Box
    mask: NDArray[np.bool_]


def cropped(mask: NDArray[np.bool_], top: int = 0, left: int = 0) -> Region | None:
    """Crop a mask, whose first pixel is (top, left) of the image, to its bounding box; None if it is empty."""
    box = bounds(mask)
    return None if box is None else Region(moved(box, top, left), mask[box].copy())


def enclosed(line: ArrayLike, shape: tuple[int, ...]) -> Region | None:
    """Pixels of an image (H, W, ...) whose centre a closed line, (n, 2) of (x, y), encloses, an odd number of times
    where it crosses itself; None for none. A line that it follows in both directions has no effect, so that one line
    can have holes."""
    points = np.asarray(line, np.float64).reshape(-1, 2)
    box = None if len(points) < 3 else box_between(points.min(axis=0), points.max(axis=0), shape)
    if box is None:
        return None
    top, left = box[0].start, box[1].start
    return cropped(odd_even_fill(points - (left, top), (box[0].stop - top, box[1].stop - left)), top, left)


@dataclass(frozen=True, eq=False)
class Block:
    """A block: the pixels of one label in their bounding box.

    Attributes
    ----------
    label : int
        Value in the label map, > 0.
    box : tuple of slice
        Rows and columns of the bounding box in the frame.
    mask : ndarray of bool, shape (h, w)
        The block's pixels inside the box.
    """

    label: int
    box: Box
    mask: NDArray[np.bool_]


def checked_labels(labels: NDArray[np.integer], shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return the label map as int32; a bool mask becomes block 1. Raise InputError if it does not have this shape
    (H, W)."""
    array = plain_array(labels)
    check_shape("The label map", array.shape, shape, remedy="Use blocks that were extracted from this frame.")
    if array.dtype.kind not in "biu" or (array.size and (array.min() < 0 or array.max() > np.iinfo(np.int32).max)):
        raise InputError("A label map must contain integers of 32 bits: 0 for no block, 1, 2, ... for blocks.")
    return array.astype(np.int32, copy=False)


def check_labels(labels: Iterable[object], known: Collection[int]) -> None:
    """Raise InputError for the first label of which there is no block."""
    for label in labels:
        if label not in known:
            there = ", ".join(map(str, sorted(known))) or "none"
            raise InputError(f"There is no block {label!r:.60}. Blocks: {there}.")


def checked_drawn(drawn: ArrayLike | None, shape: tuple[int, int]) -> NDArray[np.bool_] | None:
    """Return a read-only mask of drawn borders, None if there are none; raise InputError if it does not have this shape
    (H, W)."""
    if drawn is None:
        return None
    mask = checked_mask(drawn, shape, "drawn borders")
    return mask if mask.any() else None


def labels_in(labels: NDArray[np.int32]) -> frozenset[int]:
    """The labels of blocks that a label map has."""
    dense = labels.size == 0 or labels.max() < _DENSE
    numbers = np.flatnonzero(np.bincount(labels.ravel())) if dense else np.unique(labels)
    return frozenset(numbers.tolist()) - {0}


SPARSE = 0.05
"""A frame of which a smaller fraction is known is sparse."""

_SHARE_OF_FRAME, _FEWEST = 0.5, 3
"""Share of a sparse frame's density that is enough for a block, and number of pixels."""


def least_known_pixels(pixels: ArrayLike, share: float, fewest: int, density: float) -> NDArray[np.floating]:
    """Minimum number of known pixels that blocks need to be completed.

    Parameters
    ----------
    pixels : array_like
        Their sizes [px].
    share : float
        Minimum fraction of pixels with depth, 0-1.
    fewest : int
        Minimum number of pixels with depth.
    density : float
        Fraction of the frame's pixels with depth, 0-1. In a sparse frame, such as points of a map or lines of a lidar,
        no block is asked for more than half of it.
    """
    if density < SPARSE:
        share, fewest = min(share, _SHARE_OF_FRAME * density), min(fewest, _FEWEST)
    return np.minimum(np.maximum(fewest, np.ceil(share * np.asarray(pixels))), pixels)


def find_blocks(labels: NDArray[np.int32], only: Collection[int] | None = None) -> dict[int, Block]:
    """Return all blocks of a label map by label, in ascending order; with `only`, some of them, in its order if it is a
    sequence.

    Examples
    --------
    >>> labels = np.array([[0, 7, 7], [3, 3, 7]], np.int32)
    >>> blocks = find_blocks(labels)
    >>> list(blocks)
    [3, 7]
    >>> blocks[7].box, blocks[7].mask.tolist()
    ((slice(0, 2, None), slice(1, 3, None)), [[True, True], [False, True]])
    >>> list(find_blocks(labels, [7, 5]))
    [7]
    """
    from scipy.ndimage import find_objects

    if labels.size and labels.max() < _DENSE:
        present: Iterator[int] = itertools.count(1)
        found = find_objects(labels)
    else:
        numbers = np.unique(labels)
        offset = 0 if numbers.size and numbers[0] == 0 else 1
        present, found = iter(numbers[1 - offset :].tolist()), find_objects(np.searchsorted(numbers, labels) + offset)
    boxes = {label: (box[0], box[1]) for label, box in zip(present, found, strict=False) if box is not None}
    wanted = boxes if only is None else (only if isinstance(only, Sequence) else sorted(only))
    return {label: Block(label, boxes[label], labels[boxes[label]] == label) for label in wanted if label in boxes}


def nearest_of_block(labels: NDArray[np.int32], there: NDArray[np.bool_], mask_size: int = 5) -> NDArray[np.intp]:
    """Find for every pixel the nearest pixel of a mask in the same block.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    there : ndarray of bool, shape (H, W)
    mask_size : {3, 5}
        As for `ilf.data.pixel_grids.nearest_values`.

    Returns
    -------
    ndarray of intp, shape (H, W)
        Its flat index; -1 outside the mask where a block has no pixel of it, or there is no block.
    """
    own = np.arange(labels.size).reshape(labels.shape)
    nearest = np.where(there, own, -1)
    for block in find_blocks(labels).values():
        here = block.mask & there[block.box]
        if here.any() and (block.mask & ~here).any():
            nearest[block.box][block.mask] = nearest_values(own[block.box], here, mask_size)[1][block.mask]
    return nearest


# A frame's blocks, with all that is said about them.

_Byte = Annotated[int, msgspec.Meta(ge=0, le=255)]
Colour = tuple[_Byte, _Byte, _Byte]
"""Red, green, blue, 0-255."""

OwnValues = Mapping[str, Value]
"""Own parameters of a block: parameter -> value that replaces the common one."""


def block_colour(label: int) -> Colour:
    """Colour of a block: consecutive numbers differ much in hue, and the colour of a number is fixed."""
    hue = (label * 0.61803398875) % 1.0
    saturation = (0.75, 0.55, 0.9)[label % 3]
    value = (0.95, 0.8, 1.0)[(label // 3) % 3]
    red, green, blue = colorsys.hsv_to_rgb(hue, saturation, value)
    return round(red * 255), round(green * 255), round(blue * 255)


@dataclass(frozen=True)
class BlockInfo:
    """The user's settings of a block."""

    name: str
    colour: Colour
    visible: bool = True
    locked: bool = False


@dataclass(frozen=True, eq=False)
class Blocks:
    """A label map and all that is said about its blocks. It stands wherever a label map does (`as_blocks`).

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map, 0 = no block.
    infos : mapping of int to BlockInfo
        Block label -> its name, colour, visibility and lock. Entries of removed labels are kept, so that undo restores
        their names.
    own : mapping of int to OwnValues
        Block label -> own parameters: values that replace the common ones.
    drawn : ndarray of bool, shape (H, W), or None
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth crosses it. None for
        none.
    by_hand : DepthByHand or None
        Depth by hand. None for none.
    extraction : BlockParameters or None
        Parameters that the blocks were extracted with; None if they were not extracted.
    network : str or None
        SHA-256 of the edge network used for the extraction; None for none.
    extracted : ndarray of int32 or None
        The map directly after the extraction; None if it was changed afterwards in an unknown way.
    kept : frozenset of int
        Blocks that the extraction left unchanged, so that they do not come from it.
    handmade : frozenset of int
        Those of `kept` that were made by hand.
    propagated_from : str
        Name of the frame from which the blocks were propagated; "" if they were not. `extracted` is then the
        propagated map.
    reasons : mapping of int to str
        Block label -> why the propagated block has to be checked, one sentence.
    notes : tuple of str
        Notes for the user on how the blocks were made, one sentence each.

    Examples
    --------
    >>> blocks = as_blocks(np.eye(3, dtype=int), (3, 3))
    >>> np.asarray(blocks).sum(), blocks.edited
    (np.int64(3), True)
    """

    labels: NDArray[np.int32]
    infos: Mapping[int, BlockInfo] = field(default_factory=dict)
    own: Mapping[int, OwnValues] = field(default_factory=dict)
    drawn: NDArray[np.bool_] | None = None
    by_hand: DepthByHand | None = None
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()
    propagated_from: str = ""
    reasons: Mapping[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """The label map, for numpy."""
        return np.array(self.labels, dtype, copy=copy)

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from the extracted ones, or were not extracted."""
        return self.extraction is None or bool(self.kept) or not self._as_extracted()

    @property
    def propagated(self) -> bool:
        """Whether the blocks were propagated from another frame and have not been edited since."""
        return bool(self.propagated_from) and self._as_extracted()

    @property
    def names(self) -> dict[int, str]:
        """Label -> name, of the blocks that the user or a file has named."""
        return {label: info.name for label, info in self.infos.items() if info.name != f"Block {label}"}

    @property
    def colours(self) -> dict[int, Colour]:
        """Label -> colour, of the blocks whose colour may be another one than `block_colour`."""
        return {label: info.colour for label, info in self.infos.items()}

    @property
    def locked(self) -> frozenset[int]:
        """Labels that edits must not change."""
        return frozenset(label for label, info in self.infos.items() if info.locked)

    def parameters_of(self, label: int, common: Parameters) -> Parameters:
        """The parameters of a block: its own over the common ones."""
        own = self.own.get(label)
        return common.replace(**own) if own else common

    def drawn_of(self, block: Block) -> NDArray[np.bool_] | None:
        """Pixels of a block whose border was drawn by hand, in the order of `block.mask`'s True values; None for
        none."""
        own = None if self.drawn is None else self.drawn[block.box][block.mask]
        return own if own is not None and own.any() else None

    def by_hand_of(self, block: Block, frame: RGBDFrame) -> DepthByHand | None:
        """Depth by hand that counts in a block of a frame: at its missing pixels, in the same order; None for none."""
        if self.by_hand is None:
            return None
        missing = np.isnan(frame.depth[block.box][block.mask])
        if frame.outside_view is not None:
            missing &= ~frame.outside_view[block.box][block.mask]
        own = np.where(missing, self.by_hand.depth[block.box][block.mask], np.float32(np.nan))
        return replace(self.by_hand, depth=own) if np.isfinite(own).any() else None

    def with_parameters(self, own: Mapping[int, Parameters], common: Parameters) -> Self:
        """Return the blocks with these parameters of their own, as far as they differ from the common ones."""
        values = {label: parameters.differences_from(common) for label, parameters in own.items()}
        return replace(self, own={label: differing for label, differing in values.items() if differing})

    def without_absent(self) -> Self:
        """Return the blocks without own parameters of labels that the map lacks, which are kept for undo only."""
        if not self.own:
            return self
        present = np.bincount(self.labels.ravel(), minlength=max(self.own) + 1)
        return replace(self, own={label: values for label, values in self.own.items() if present[label]})

    def _as_extracted(self) -> bool:
        labels, extracted = self.labels, self.extracted
        if extracted is None or extracted is labels:
            return extracted is labels
        return all(np.array_equal(extracted[rows], labels[rows]) for rows, *_ in strips(len(labels)))


def as_blocks(given: ArrayLike | Blocks, shape: tuple[int, int]) -> Blocks:
    """Return blocks whose arrays are checked and read-only, from blocks or a label map; a bool mask is block 1.

    Raises
    ------
    InputError
        If the label map, the mask of drawn borders or depth by hand does not have this shape (H, W).
    """
    blocks = given if isinstance(given, Blocks) else Blocks(plain_array(given))
    labels = read_only(checked_labels(blocks.labels, shape))
    return replace(
        blocks,
        labels=labels,
        extracted=labels if blocks.extracted is blocks.labels else blocks.extracted,
        drawn=checked_drawn(blocks.drawn, shape),
        by_hand=None if blocks.by_hand is None else as_by_hand(blocks.by_hand, shape),
    )

"""Blocks: a frame's label map with all that is said about its blocks."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Self

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import plain_array
from .by_hand import DepthByHand, as_by_hand
from .declarations import Value
from .frame import read_only
from .label_map import checked_drawn, checked_labels
from .parameters import BlockParameters, Parameters

_Byte = Annotated[int, msgspec.Meta(ge=0, le=255)]
Colour = tuple[_Byte, _Byte, _Byte]
"""Red, green, blue, 0-255."""

OwnValues = Mapping[str, Value]
"""Own parameters of a block: parameter -> value that replaces the common one."""

_STRIP = 64
"""Rows compared at a time; the comparison stops at the first difference."""


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
        strips = (slice(top, top + _STRIP) for top in range(0, labels.shape[0], _STRIP))
        return all(np.array_equal(extracted[strip], labels[strip]) for strip in strips)


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

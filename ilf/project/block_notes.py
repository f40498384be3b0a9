"""What is known of a frame's blocks beside their pixels."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..parameters import BlockParameters
from .own_values import OwnValues


@dataclass(frozen=True)
class BlockInfo:
    """What a user can say about a block, beside its pixels."""

    name: str
    colour: tuple[int, int, int]
    visible: bool = True
    locked: bool = False


@dataclass(eq=False)
class BlockNotes:
    """What is known of a label map beside its pixels; replaced as a whole when the map is.

    Attributes
    ----------
    infos : dict
        Block label -> BlockInfo. Kept for labels that are gone, so that undo brings names back.
    own : dict
        Block label -> values of its own, parameter by parameter, in place of those of all blocks.
    drawn : ndarray of bool or None
        Pixels of blocks whose border was drawn by hand; None if there are none.
    extraction : BlockParameters or None
        What the blocks were extracted with.
    network : str or None
        SHA-256 of the edge network that had a part in it.
    extracted : ndarray of int32 or None
        The map as that extraction left it; None if it was changed afterwards in ways that are not known.
    kept : frozenset of int
        Blocks that stayed as they were at that extraction, and do not come from it.
    handmade : frozenset of int
        Those of them that had been made by hand.
    carried_from : str
        Name of the frame from which the blocks were carried here; "" if they were not. `extracted` is the map as they
        came then.
    reasons : dict
        Block label -> why it needed a look when it came, a sentence.
    """

    infos: dict[int, BlockInfo] = field(default_factory=dict)
    own: dict[int, OwnValues] = field(default_factory=dict)
    drawn: NDArray[np.bool_] | None = None
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()
    carried_from: str = ""
    reasons: dict[int, str] = field(default_factory=dict)

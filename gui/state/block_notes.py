"""Data of a label map beside its pixels, while a frame is open in the window."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import BlockInfo, Blocks, OwnValues
from ilf.data.by_hand import DepthByHand
from ilf.data.parameters import BlockParameters


@dataclass(eq=False)
class BlockNotes:
    """Data of a label map beside its pixels, as in `Blocks`; replaced together with the map."""

    infos: dict[int, BlockInfo] = field(default_factory=dict)
    own: dict[int, OwnValues] = field(default_factory=dict)
    drawn: NDArray[np.bool_] | None = None
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()
    propagated_from: str = ""
    reasons: dict[int, str] = field(default_factory=dict)

    @classmethod
    def of(cls, blocks: Blocks) -> Self:
        """The notes of blocks, to be changed."""
        values: dict[str, Any] = {one.name: getattr(blocks, one.name) for one in fields(cls)}
        drawn = None if blocks.drawn is None else blocks.drawn.copy()
        return cls(**values | {"infos": dict(blocks.infos), "own": dict(blocks.own), "drawn": drawn})

    def blocks(self, labels: NDArray[np.int32], by_hand: DepthByHand | None) -> Blocks:
        """The blocks of a label map with these notes."""
        values: dict[str, Any] = {one.name: getattr(self, one.name) for one in fields(self)}
        return Blocks(labels, by_hand=by_hand, **values | {"infos": dict(self.infos), "own": dict(self.own)})

"""The inputs of a run: plain data that is run, recorded, replayed and written."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..data.by_hand import DepthByHand, as_by_hand
from ..data.frame import RGBDFrame, checked_frame, read_only
from ..data.label_map import checked_drawn, checked_labels
from ..data.parameters import BlockParameters, Parameters
from ..data.presets import as_parameters, preset


@dataclass(frozen=True, eq=False)
class RunSetup:
    """Frame, blocks and parameters of a run; see `Run`."""

    frame: RGBDFrame
    blocks: NDArray[np.int32]
    parameters: Parameters = field(default_factory=preset)
    own: Mapping[int, Parameters] = field(default_factory=dict)
    only: Collection[int] | None = None
    extrapolate: bool = False
    extraction: BlockParameters | None = None
    edited: bool = False
    network: str | None = None
    notes: tuple[str, ...] = ()
    drawn: NDArray[np.bool_] | None = None
    by_hand: DepthByHand | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", read_only(checked_labels(self.blocks, checked_frame(self.frame).shape)))
        object.__setattr__(self, "drawn", checked_drawn(self.drawn, self.frame.shape))
        object.__setattr__(self, "by_hand", as_by_hand(self.by_hand, self.frame.shape))
        object.__setattr__(self, "parameters", as_parameters(self.parameters))
        own = {label: as_parameters(parameters) for label, parameters in self.own.items()}
        object.__setattr__(self, "own", MappingProxyType(own))
        object.__setattr__(self, "edited", self.edited or self.extraction is None)

    def parameters_of(self, label: int) -> Parameters:
        """Parameters of a block."""
        return self.own.get(label, self.parameters)

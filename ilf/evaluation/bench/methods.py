"""The methods of the bench: all presets and the peers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...completion.interpolation import linear, nearest
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS, Parameters
from ...run.run import complete
from . import peers

Depth = NDArray[np.floating]


Method = Callable[[RGBDFrame, NDArray[np.int32]], Depth]
"""Takes a frame and its label map, returns depth [m] of shape (H, W), NaN where it does not fill."""


def _preset(parameters: Parameters) -> Method:
    return lambda frame, labels: complete(frame, labels, parameters).depth


def _peer(run: Callable[[RGBDFrame], Depth]) -> Method:
    return lambda frame, _: run(frame)


_PEERS: dict[str, Method] = {
    "nearest": _peer(nearest),
    "linear": _peer(linear),
    "navier-stokes": _peer(peers.navier_stokes),
    "telea": _peer(peers.telea),
    "laplace": _peer(peers.laplace),
    "colourisation": _peer(peers.colourisation),
    "thin-plate": _peer(peers.thin_plate),
    "soft-thin-plate": _peer(peers.soft_thin_plate),
    "dct-smoothing": _peer(peers.dct_smoothing),
    "polynomial": peers.polynomial,
    "morphology": _peer(peers.morphology),
}

METHODS = {name: _preset(values) for name, values in PRESETS.items()} | _PEERS
"""Name -> method, presets first."""

BY_BLOCKS = (*PRESETS, "polynomial")
"""Methods that use the label map."""

GROUPS = {"presets": tuple(PRESETS), "peers": tuple(_PEERS)}
"""Names of groups of methods."""

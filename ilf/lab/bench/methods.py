"""The methods of the bench: all presets and the peers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...completion.interpolation import linear, nearest
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS, Parameters
from ...run.run import complete
from .frames import parse_names
from .peers import (
    colourisation,
    dct_smoothing,
    laplace,
    morphology,
    navier_stokes,
    polynomial,
    soft_thin_plate,
    telea,
    thin_plate,
)

Depth = NDArray[np.floating]


@dataclass(frozen=True)
class Method:
    """A method that completes depth.

    Attributes
    ----------
    name : str
    run : callable
        Takes a frame and its label map, returns depth [m] of shape (H, W), NaN where it does not fill.
    needs_blocks : bool
        False if the method ignores the label map.
    """

    name: str
    run: Callable[[RGBDFrame, NDArray[np.int32]], Depth]
    needs_blocks: bool


def _preset(name: str, parameters: Parameters) -> Method:
    return Method(name, lambda frame, labels: complete(frame, labels, parameters).depth, True)


def _peer(name: str, run: Callable[[RGBDFrame], Depth]) -> Method:
    return Method(name, lambda frame, _: run(frame), False)


_PEERS = (
    _peer("nearest", nearest),
    _peer("linear", linear),
    _peer("navier-stokes", navier_stokes),
    _peer("telea", telea),
    _peer("laplace", laplace),
    _peer("colourisation", colourisation),
    _peer("thin-plate", thin_plate),
    _peer("soft-thin-plate", soft_thin_plate),
    _peer("dct-smoothing", dct_smoothing),
    Method("polynomial", polynomial, True),
    _peer("morphology", morphology),
)

GROUPS = {
    "presets": tuple(PRESETS),
    "peers": tuple(method.name for method in _PEERS),
}
"""Names of groups of methods; "all" means all groups."""

METHODS: dict[str, Method] = {
    method.name: method for method in (*(_preset(name, values) for name, values in PRESETS.items()), *_PEERS)
}
"""Name -> method, presets first."""


def parse_methods(names: str) -> list[str]:
    """Parse a comma-separated list of methods, each named once.

    Parameters
    ----------
    names : str
        Methods, "presets", "peers", or "all".

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    return parse_names(names, METHODS, {"all": tuple(METHODS), **GROUPS})

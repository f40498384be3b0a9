"""What a network that has learnt from generated scenes still changes about completed depth."""

from __future__ import annotations

from ..models import CORRECTION, model_path
from ..parameters import Parameters, preset
from .correction import Correction, changes_any, corrections, made_of
from .network import CorrectionNetwork

__all__ = [
    "UNCORRECTED",
    "Correction",
    "CorrectionNetwork",
    "changes_any",
    "corrections",
    "corrects",
    "load_correction_network",
    "made_of",
]

UNCORRECTED = preset("best", correction=False)
"""What the network has seen the depth completed with."""


def corrects(parameters: Parameters) -> bool:
    """Whether what is completed with such parameters is corrected."""
    return parameters.filter == "edge-aware" and parameters.correction


def load_correction_network() -> CorrectionNetwork:
    """The correction network that comes with the program.

    Raises
    ------
    InputError
        If its file is missing.
    FormatError
        If it is no such network.
    """
    return CorrectionNetwork.load(model_path(CORRECTION))

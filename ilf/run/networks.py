"""Which network had a part in a run, by name."""

from __future__ import annotations

from ..correction import load_correction_network
from ..edges.depth_network import DepthEdgeNetwork
from ..edges.network import load_model
from ..errors import InputError
from ..models import CORRECTION, DEPTH_EDGES, model_path

Asked = tuple[str, ...]
"""Names of networks: the one that is asked for, and the one that stands in where that does not work."""


def asked_networks(detector: str, model: str) -> Asked:
    """The networks that edges may come from.

    Parameters
    ----------
    detector : str
        `BlockParameters.detector` or `Parameters.edges`.
    model : str
        The network of contours that is chosen beside it.

    Examples
    --------
    >>> asked_networks("rgbd", "edges"), asked_networks("combined", "mine"), asked_networks("canny", "edges")
    (('depth-edges', 'edges'), ('mine',), ())
    """
    return {"canny": (), "rgbd": (DEPTH_EDGES, model)}.get(detector, (model,))


def used_network(sha256: str | None, asked: Asked) -> dict[str, str]:
    """Name -> SHA-256 of the network that was used: of those asked for the one that has that very file, else the first;
    empty if none was."""
    if sha256 is None or not asked:
        return {}
    return {next((name for name in asked[1:] if present_sha256(name) == sha256), asked[0]): sha256}


def present_sha256(name: str) -> str | None:
    """SHA-256 of the network of a name as it is now; None if there is none that works.

    Raises
    ------
    InstallationError
        If no network can be read here.
    """
    try:
        if name == CORRECTION:
            return load_correction_network().sha256
        return (DepthEdgeNetwork.load(model_path(name)) if name == DEPTH_EDGES else load_model(name)).sha256
    except InputError:
        return None

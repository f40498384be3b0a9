"""Edge strength of a frame or of a colour image, by one detector."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..models import BUNDLED
from ..parameters import BlockParameters
from .frame_edges import canny_strength, depth_edges, find_edges, load_depth_network, network_strength
from .network import check_image, load_model
from .relief import find_relief

DETECTORS = ("rgbd", "combined", "hed", "canny", "depth")
"""What `edge_strength` takes."""

_OF_FRAMES = ("rgbd", "combined", "depth")
"""Those that need known depth."""


def edge_strength(
    image: RGBDFrame | ArrayLike, detector: str = "combined", *, model: str = BUNDLED, multiscale: bool = False
) -> NDArray[np.float32]:
    """Edge strength by one detector (section 2).

    Parameters
    ----------
    image : RGBDFrame, or array of uint8, shape (H, W, 3)
        A frame, or a colour image (RGB), which serves "hed" and "canny".
    detector : str
        "hed": contours by the edge network. "canny": Canny's edges at 1, the colour gradient up to 0.9 elsewhere.
        "depth": 1 at jumps of the known depth, 0 elsewhere. "combined": the larger of "hed" and "depth". "rgbd": the
        probability of a depth jump by the network that looks at colour and known depth, and 1 at jumps of that.
    model : str
        Name of the network of "hed" and "combined", one of `ilf.models.model_names()`.
    multiscale : bool
        Let that network look at three scales: slightly better, 3.5 times as slow.

    Returns
    -------
    ndarray of float32, shape (H, W)
        In [0, 1].

    Raises
    ------
    InputError
        For an unknown detector, an image of another kind or without depth where that is needed, or an edge network
        that is missing or none.

    Examples
    --------
    >>> import numpy as np
    >>> rgb = np.zeros((20, 30, 3), np.uint8)
    >>> rgb[:, 15:] = 200
    >>> edge_strength(rgb, "canny")[10, [3, 14]].tolist()
    [0.0, 1.0]
    """
    if detector not in DETECTORS:
        raise InputError(f"There is no detector {detector!r}. Choose one of {', '.join(DETECTORS)}.")
    defaults = BlockParameters(detector="hed", model=model, multiscale=multiscale)
    frame = image if isinstance(image, RGBDFrame) else None
    if frame is None and detector in _OF_FRAMES:
        raise InputError(
            f"The detector {detector!r} needs a frame with depth (ilf.RGBDFrame); 'hed' and 'canny' take colour alone."
        )
    rgb = np.asarray(image) if frame is None else frame.rgb
    check_image(rgb)
    if detector == "canny":
        return canny_strength(rgb, defaults.canny_sigma, defaults.canny_high, defaults.canny_low_ratio)
    if frame is None:
        return load_model(model).strength(rgb, multiscale)
    if detector == "depth":
        return find_relief(frame.depth, defaults.depth_jump, defaults.depth_jump_share).edges.astype(np.float32)
    # here, nothing stands in for a network that is missing
    if detector == "rgbd":
        depth_edges(frame, load_depth_network())
        return find_edges(frame, defaults.replace(detector="rgbd")).strength.copy()
    by_network = network_strength(frame.rgb, load_model(model), multiscale)
    return (by_network if detector == "hed" else find_edges(frame, defaults).strength).copy()

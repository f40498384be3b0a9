"""The nearest pixel of some, seen from every pixel."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]


def nearest_values(values: Array, there: NDArray[np.bool_], mask_size: int = 5) -> tuple[Array, Array]:
    """How far it is to the nearest of some pixels, and what is there.

    Parameters
    ----------
    values : (H, W) float32
        Looked at where `there` is True.
    there : (H, W) bool
    mask_size : {3, 5}
        Of the chamfer distance: 5 is closer to the Euclidean one, 3 is faster.

    Returns
    -------
    (H, W) float32, (H, W) float32
        Distance [px], 0 where `there`; and the value there. Values are 0 if there is no such pixel.
    """
    distance, places = cv2.distanceTransformWithLabels(
        (~there).astype(np.uint8), cv2.DIST_L2, mask_size, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_place = np.zeros(int(places.max()) + 1, np.float32)
    of_place[places[there]] = values[there]
    return np.asarray(distance, np.float32), of_place[places]

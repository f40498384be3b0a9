"""What networks expect of their input, as a 1 x 1 convolution of RGB in [0, 1]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_CAFFE_MEAN = (104.00698793, 116.66876762, 122.67891434)
_IMAGENET_MEAN, _IMAGENET_DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)

INPUTS = {
    "rgb": "RGB in 0 to 1",
    "imagenet": "RGB less the mean of ImageNet, over its standard deviation",
    "caffe": "BGR in 0 to 255 less HED's mean",
}


def normalisation(name: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The convolution that turns RGB in [0, 1] into one of `INPUTS`.

    Returns
    -------
    weight : ndarray of float32, shape (3, 3, 1, 1)
    bias : ndarray of float32, shape (3,)
    """
    if name == "rgb":
        weight, bias = np.eye(3), np.zeros(3)
    elif name == "imagenet":
        weight, bias = np.diag(np.reciprocal(_IMAGENET_DEVIATION)), -np.divide(_IMAGENET_MEAN, _IMAGENET_DEVIATION)
    else:
        weight, bias = 255 * np.eye(3)[::-1], -np.asarray(_CAFFE_MEAN)
    return weight.astype(np.float32)[..., None, None], bias.astype(np.float32)

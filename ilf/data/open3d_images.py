"""Open3D, and frames to and from it. Open3D is imported on first use, because that takes seconds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import load_libusb, remedy
from ..errors import ExportError, InputError
from .camera import Camera, camera_from_numbers

# libraries that Open3D is linked against and minimal systems lack
_LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libgomp.so.1", "libidn2.so.0", "libudev.so.1")


def load_open3d(purpose: str = "Open3D's data") -> Any:
    """Import the module open3d.

    Parameters
    ----------
    purpose : str
        What needs it, as the subject of a sentence.

    Raises
    ------
    ExportError
        If it is not installed or cannot be loaded; the message states what to install.
    """
    load_libusb()
    try:
        import open3d
    except (ImportError, OSError) as error:
        raise ExportError(
            f"{purpose} needs the package open3d, {remedy('open3d', 'ilf-studio[app]', error, _LIBRARIES)}"
        ) from error
    return open3d


def image_of(rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> Any:
    """Convert colour and depth [m] to an `open3d.geometry.RGBDImage`, with 0 for missing depth."""
    o3d = load_open3d()
    return o3d.geometry.RGBDImage.create_from_color_and_depth(
        o3d.geometry.Image(np.ascontiguousarray(rgb)),
        o3d.geometry.Image(np.nan_to_num(depth, nan=0.0)),
        depth_scale=1.0,
        depth_trunc=float(np.finfo(np.float32).max),
        convert_rgb_to_intensity=False,
    )


def arrays_of(image: Any, depth_units: float | None) -> tuple[NDArray[Any], NDArray[np.floating]]:
    """Return colour (H, W, 3) and depth [m] (H, W) of an RGBDImage of `open3d.geometry` or `open3d.t.geometry`.

    Raises
    ------
    InputError
        If it is not such an image, is grey instead of colour, or its depth is integer and no units are given.
    """
    if not (hasattr(image, "color") and hasattr(image, "depth")):
        raise InputError(f"An RGBDImage of Open3D is needed, not {type(image).__name__}.")
    rgb, depth = _array(image.color), _array(image.depth)
    if rgb.ndim != 3 or rgb.shape[2] != 3:
        raise InputError("The image is grey: create it with convert_rgb_to_intensity=False, which is not the default.")
    if depth.ndim == 3 and depth.shape[2] == 1:
        depth = depth[..., 0]
    if depth_units is None and depth.dtype.kind in "iu":
        raise InputError(f"The image's depth is {depth.dtype}: give depth_units per metre, 1000 for millimetres.")
    return rgb, depth.astype(np.float64) / (1.0 if depth_units is None else depth_units)


def camera_of_open3d(intrinsics: Any) -> Camera | None:
    """Convert a PinholeCameraIntrinsic or a 3 x 3 matrix (also as a tensor) to intrinsics; return intrinsics as is."""
    if intrinsics is None or isinstance(intrinsics, Camera):
        return intrinsics
    matrix = getattr(intrinsics, "intrinsic_matrix", intrinsics)
    return camera_from_numbers(_array(matrix), "open3d")


def _array(values: Any) -> NDArray[Any]:
    """Convert an image of Open3D's legacy or tensor API, or a tensor on any device, to a numpy array."""
    if hasattr(values, "as_tensor"):
        values = values.as_tensor()
    return np.asarray(values.cpu().numpy() if hasattr(values, "cpu") else values)

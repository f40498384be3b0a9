"""Frames as Open3D has them, and back. Open3D is imported when it is needed, because that takes seconds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import load_libusb, way_out
from ..errors import ExportError, InputError
from .camera import CameraIntrinsics, camera_from_numbers

# what Open3D is linked against that bare machines lack
_LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libgomp.so.1", "libidn2.so.0", "libudev.so.1")


def load_open3d() -> Any:
    """The open3d module.

    Raises
    ------
    ExportError
        If it is not installed or cannot be loaded; the message names what to install.
    """
    load_libusb()
    try:
        import open3d
    except (ImportError, OSError) as error:
        raise ExportError(
            f"Open3D's images need the package open3d, {way_out('open3d', 'cloud', error, _LIBRARIES)}"
        ) from error
    return open3d


def image_of(rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> Any:
    """Colour and depth [m] as an `open3d.geometry.RGBDImage`, in which missing depth is 0."""
    o3d = load_open3d()
    return o3d.geometry.RGBDImage.create_from_color_and_depth(
        o3d.geometry.Image(np.ascontiguousarray(rgb)),
        o3d.geometry.Image(np.nan_to_num(depth, nan=0.0)),
        depth_scale=1.0,
        depth_trunc=float(np.finfo(np.float32).max),
        convert_rgb_to_intensity=False,
    )


def pinhole_of(camera: CameraIntrinsics, shape: tuple[int, int]) -> Any:
    """Intrinsics for images (H, W) as an `open3d.camera.PinholeCameraIntrinsic`."""
    pinhole = load_open3d().camera.PinholeCameraIntrinsic
    return pinhole(shape[1], shape[0], camera.fx, camera.fy, camera.cx, camera.cy)


def arrays_of(image: Any, depth_units: float | None) -> tuple[NDArray[Any], NDArray[np.floating]]:
    """Colour (H, W, 3) and depth [m] (H, W) of an RGBDImage, of `open3d.geometry` or `open3d.t.geometry`.

    Raises
    ------
    InputError
        If it is no such image, has grey in place of colour, or its depth has whole numbers and no units are given.
    """
    if not (hasattr(image, "color") and hasattr(image, "depth")):
        raise InputError(f"This is no RGBDImage of Open3D, but {type(image).__name__}.")
    rgb, depth = _array(image.color), _array(image.depth)
    if rgb.ndim != 3 or rgb.shape[2] != 3:
        raise InputError(
            "The image has grey in place of colour: make it with convert_rgb_to_intensity=False, as "
            "RGBDImage.create_from_color_and_depth does not by itself."
        )
    if depth.ndim == 3 and depth.shape[2] == 1:
        depth = depth[..., 0]
    if depth_units is None and depth.dtype.kind in "iu":
        raise InputError(
            f"The image's depth is {depth.dtype}: give depth_units, how many make a metre (1000 for millimetres)."
        )
    return rgb, depth.astype(np.float64) / (1.0 if depth_units is None else depth_units)


def camera_of_open3d(intrinsics: Any) -> CameraIntrinsics | None:
    """Intrinsics from a PinholeCameraIntrinsic, a 3 x 3 matrix (also as a tensor), or what they are already."""
    if intrinsics is None or isinstance(intrinsics, CameraIntrinsics):
        return intrinsics
    matrix = getattr(intrinsics, "intrinsic_matrix", intrinsics)
    return camera_from_numbers(_array(matrix), "open3d")


def _array(values: Any) -> NDArray[Any]:
    """A numpy array of an image of Open3D, old or new, or of a tensor on any device."""
    if hasattr(values, "as_tensor"):
        values = values.as_tensor()
    return np.asarray(values.cpu().numpy() if hasattr(values, "cpu") else values)

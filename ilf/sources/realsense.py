"""Capturing frames with a connected RealSense camera."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing, suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import load_libusb, optional
from ..data.camera import Camera, lens_of, rigid_transform
from ..data.frame import RGBDFrame
from ..errors import InputError, told_as
from .registration import RawPair, register

SETTLING = 30
"""Frames until exposure and white balance have settled."""
_TIMEOUT_MS = 5000


def capture_frame(settle: int = SETTLING) -> RGBDFrame:
    """Capture a frame with the connected RealSense camera.

    Parameters
    ----------
    settle : int
        Number of frames to skip first, until exposure and white balance have settled.

    Returns
    -------
    RGBDFrame
        Depth [m] registered to colour, see `ilf.sources.registration.register`.

    Raises
    ------
    InputError
        If the package is not installed (extra `sensors`), there is no camera, it delivers no frames, or its images do
        not make a valid frame.
    """
    with closing(camera_pairs(settle)) as pairs:
        return register(next(pairs))


def camera_pairs(settle: int = SETTLING) -> Generator[RawPair, None, None]:
    """Yield what the connected RealSense camera captures, always the latest, until it is closed.

    Parameters
    ----------
    settle : int
        Number of frames to skip first, until exposure and white balance have settled.

    Raises
    ------
    InputError
        If the package is not installed (extra `sensors`), there is no camera, or it delivers no more frames.
    """
    library = load_realsense()
    if not len(library.context().query_devices()):
        raise InputError("No RealSense camera is connected. Connect one via USB 3.")
    pipeline, stream_config = library.pipeline(), library.config()
    stream_config.enable_stream(library.stream.depth, library.format.z16)
    stream_config.enable_stream(library.stream.color, library.format.rgb8)
    told = "The RealSense camera gives no colour and depth ({error}). Connect it via USB 3, and close other programs."
    with told_as(InputError, told, RuntimeError):
        pipeline.start(stream_config)
    try:
        for _ in range(settle):
            _wait(pipeline)
        while True:
            yield pair_of(_wait(pipeline))
    finally:
        with suppress(RuntimeError):  # a camera that is no longer connected
            pipeline.stop()


def _wait(pipeline: Any) -> Any:
    with told_as(InputError, "The RealSense camera sent no frame ({error}). Reconnect it via USB 3.", RuntimeError):
        return pipeline.wait_for_frames(_TIMEOUT_MS)


def load_realsense() -> Any:
    """Load pyrealsense2; raises InputError with what to install if it is missing or cannot be loaded."""
    load_libusb()
    return optional("pyrealsense2", "ilf-studio[sensors]", "A RealSense camera")


def pair_of(frames: Any, name: str = "realsense") -> RawPair:
    """The raw pair of a composite frame of pyrealsense2.

    Parameters
    ----------
    frames : pyrealsense2.composite_frame
        With depth (Z16) and colour (RGB8).
    name : str
        Name of the frame.

    Raises
    ------
    InputError
        If colour or depth is missing, or its lens model is not supported.
    """
    depth, colour = frames.get_depth_frame(), frames.get_color_frame()
    if not depth or not colour:
        raise InputError(f"The camera delivered a frame without {'colour' if depth else 'depth'}. Try again.")
    values = np.asanyarray(depth.get_data()).astype(np.float32)
    motion = depth.profile.get_extrinsics_to(colour.profile)
    return RawPair(
        np.asanyarray(colour.get_data()).copy(),
        values * np.float32(depth.get_units()),
        _camera(colour),
        _camera(depth),
        rigid_transform(np.reshape(motion.rotation, (3, 3)).T, motion.translation),  # it is column by column
        name,
    )


def _camera(frame: Any) -> Camera:
    seen = frame.profile.as_video_stream_profile().intrinsics
    coefficients: NDArray[np.float64] = np.array(seen.coeffs, float)
    facts = {"fx": seen.fx, "fy": seen.fy, "cx": seen.ppx, "cy": seen.ppy, "width": seen.width, "height": seen.height}
    if coefficients.any():
        facts |= {"lens": seen.model.name, "distortion": coefficients.tolist()}
    return lens_of(facts)

"""A completed frame as a file of the viewer Rerun (.rrd): images, blocks, expected error and curves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .._runtime.installation import optional
from ..completion.confidence.expected_error import expected_error
from ..data.blocks import block_colour
from ..data.frame import RGBDFrame
from ..data.results import Completion

CAMERA = "world/camera"
"""Entity with the images of the camera: colour, depth, completed and blocks."""

ERROR = "expected_error"
"""Entity with the expected error [m]; NaN where nothing was filled."""

CURVES = ("sigma_i", "l1")
"""Values of the iterations' records [m], and entities with a curve of them for each block, along `TIMELINE`."""

TIMELINE = "iteration"


class RerunFile:
    """The exporter of Rerun files.

    Raises
    ------
    InputError
        If Rerun's package is not installed.
    """

    def __init__(self) -> None:
        self._rerun: Any = optional("rerun", "rerun-sdk", "A Rerun file (.rrd)")
        self._blueprint: Any = optional("rerun.blueprint", "rerun-sdk", "A Rerun file (.rrd)")

    def write(self, path: Path, completion: Completion) -> None:
        """Write a completed frame: depth in metres, NaN = missing; without intrinsics there are only 2D views."""
        rerun = self._rerun
        stream = rerun.RecordingStream("ilf-studio")
        stream.save(path, default_blueprint=self._views(completion.frame))
        stream.send_recording_name(completion.frame.name)
        self._log_camera(stream, completion.frame)
        images = {
            f"{CAMERA}/colour": rerun.Image(completion.frame.rgb),
            f"{CAMERA}/depth": rerun.DepthImage(completion.frame.depth, meter=1.0),
            f"{CAMERA}/completed": rerun.DepthImage(completion.depth, meter=1.0),
            f"{CAMERA}/blocks": rerun.SegmentationImage(completion.blocks.astype(np.uint32)),
            ERROR: rerun.DepthImage(expected_error(completion), meter=1.0),
        }
        for entity, image in images.items():
            stream.log(entity, image, static=True)
        classes = [(label, f"block {label}", block_colour(label)) for label in completion.results]
        stream.log(CAMERA, rerun.AnnotationContext(classes), static=True)
        self._log_curves(stream, completion)
        stream.disconnect()

    def _log_camera(self, stream: Any, frame: RGBDFrame) -> None:
        rerun, camera = self._rerun, frame.intrinsics
        stream.log("world", rerun.ViewCoordinates.RIGHT_HAND_Y_DOWN, static=True)
        if frame.pose is not None:
            pose = rerun.Transform3D(translation=frame.pose[:3, 3], mat3x3=frame.pose[:3, :3])
            stream.log(CAMERA, pose, static=True)
        if camera is not None:
            pinhole = rerun.Pinhole(image_from_camera=camera.matrix, resolution=frame.shape[::-1])
            stream.log(CAMERA, pinhole, static=True)

    def _log_curves(self, stream: Any, completion: Completion) -> None:
        rerun = self._rerun
        for label, history in completion.history.items():
            if not history:
                continue
            iterations = rerun.TimeColumn(TIMELINE, sequence=[record.i for record in history])
            style = rerun.SeriesLines(names=f"block {label}", colors=block_colour(label))
            for curve in CURVES:
                entity = f"{curve}/block_{label}"
                values = rerun.Scalars.columns(scalars=[getattr(record, curve) for record in history])
                stream.log(entity, style, static=True)
                stream.send_columns(entity, indexes=[iterations], columns=values)

    def _views(self, frame: RGBDFrame) -> Any:
        """The arrangement in which the viewer opens the file."""
        views = self._blueprint
        images = [
            views.Spatial2DView(origin=CAMERA, contents=f"{CAMERA}/{name}", name=name.capitalize())
            for name in ("colour", "blocks", "depth", "completed")
        ]
        images.append(views.Spatial2DView(origin=ERROR, name="Expected error [m]"))
        curves = [views.TimeSeriesView(origin=curve, name=f"{curve} [m]") for curve in CURVES]
        columns = [views.Grid(*images), views.Vertical(*curves)]
        if frame.intrinsics is not None:
            contents = [f"{CAMERA}/completed", f"{CAMERA}/colour"]
            columns.insert(0, views.Spatial3DView(origin="world", contents=contents, name="Completed"))
        return views.Blueprint(views.Horizontal(*columns), auto_views=False)

"""Brings the completed depth to the view of the point cloud, for those who look at it."""

from __future__ import annotations

import weakref

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject

from gui.cloud.cloud_view import CloudView
from gui.state.workspace import Workspace
from ilf.cloud import point_cloud

_NO_INTRINSICS = (
    "This frame has no camera intrinsics, which a point cloud needs.\n"
    "Open it again and choose a camera, or give fx, fy, cx, cy."
)


class CloudPresenter(QObject):
    """The cloud of the present frame, made anew when its depth has changed and the view is to be seen."""

    def __init__(self, workspace: Workspace, cloud: CloudView) -> None:
        super().__init__(cloud)
        self._workspace = workspace
        self._cloud = cloud
        self._key = ""
        # closed frames shall not be kept by what was once shown of them
        self._depth: weakref.ref[NDArray[np.float32]] | None = None

    def show(self) -> None:
        """The cloud, or why there is none."""
        if not self._cloud.isVisible():
            return
        if not self._workspace.has_session:
            self._key, self._depth = "", None
            self._cloud.set_message()
            return
        session = self._workspace.session
        frame, completion = session.frame, session.completion()
        depth = frame.depth if completion is None else completion.depth
        if self._depth is not None and depth is self._depth():
            return
        same, self._key, self._depth = session.key == self._key, session.key, weakref.ref(depth)
        if frame.intrinsics is None:
            self._cloud.set_message(_NO_INTRINSICS)
            return
        points = point_cloud(depth, frame.rgb, frame.intrinsics)
        self._cloud.set_cloud(points.points, points.colours, reset=not same)
        if completion is not None:
            there = np.isfinite(depth)
            self._cloud.set_filled(completion.filled[there], completion.guessed[there])

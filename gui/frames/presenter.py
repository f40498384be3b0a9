"""Brings the open frames to their list, and what is chosen there to the workspace."""

from __future__ import annotations

import cv2
import numpy as np
from PySide6.QtCore import QObject

from gui.frames.frame_list import FrameList
from gui.state.session import Session
from gui.state.workspace import Workspace

_THUMBNAIL_WIDTH = 160


class FramesPresenter(QObject):
    """The list of open frames: which there are, how they stand, which is the present one."""

    def __init__(self, workspace: Workspace, frames: FrameList) -> None:
        super().__init__(frames)
        self._workspace = workspace
        self._frames = frames
        frames.activated.connect(self.choose)

    def show(self) -> None:
        """The frames that are open, and what there is to say of each."""
        sessions = {session.key: session for session in self._workspace.sessions}
        listed = self._frames.keys()
        for key in set(listed) - set(sessions):
            self._frames.remove_frame(key)
        for key, session in sessions.items():
            if key not in listed:
                self._add(session)
            self._frames.update_detail(key, _detail(session))
        if self._workspace.has_session:
            self._frames.set_current(self._workspace.session.key)

    def _add(self, session: Session) -> None:
        rgb = session.frame.rgb
        height = max(round(_THUMBNAIL_WIDTH * rgb.shape[0] / rgb.shape[1]), 1)
        small = cv2.resize(rgb, (_THUMBNAIL_WIDTH, height), interpolation=cv2.INTER_AREA)
        self._frames.add_frame(session.key, session.name, small.astype(np.uint8, copy=False))

    def choose(self, key: str) -> None:
        """Make a frame of the list the present one."""
        session = self._workspace.session_of(key)
        if session is not None:
            self._workspace.show_session(session)

    def turn(self, steps: int) -> None:
        """Next or previous frame of the list."""
        sessions = self._workspace.sessions
        if len(sessions) > 1:
            position = sessions.index(self._workspace.session)
            self._workspace.show_session(sessions[(position + steps) % len(sessions)])


def _detail(session: Session) -> str:
    height, width = session.frame.shape
    results = session.valid_results()
    state = f"{len(results)} of {len(session.counts())} blocks run" if results else "not run"
    return f"{width} x {height}, {session.frame.missing_share:.1%} missing\n{state}"

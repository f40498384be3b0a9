"""Says what is under the cursor: position, block, depth in and out, expected error, compared runs, truth and error."""

from __future__ import annotations

import html

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QLabel

from gui.state.session import Session
from gui.state.workspace import Workspace


class ReadoutPresenter(QObject):
    """The readout of the pixel under the cursor."""

    def __init__(self, workspace: Workspace, label: QLabel) -> None:
        super().__init__(label)
        self._workspace = workspace
        self._label = label
        self._pixel: tuple[int, int] | None = None

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """The cursor has moved to pixel (x, y), or off the frame."""
        self._pixel = pixel
        self.show()

    def show(self) -> None:
        """What there is at the pixel under the cursor."""
        self._label.setText("" if self._pixel is None else "  |  ".join(self._parts(*self._pixel)))

    def _parts(self, x: int, y: int) -> list[str]:
        if not self._workspace.has_session:
            return []
        session = self._workspace.session
        height, width = session.frame.shape
        if x >= width or y >= height:  # the cursor has not moved yet since another frame was shown
            return []
        label = int(session.labels[y, x])
        block = session.info(label).name if label else "no block"
        depth_in, measured = float(session.frame.depth[y, x]), float(session.frame.measured[y, x])
        distrusted = np.isfinite(measured) and not np.isfinite(depth_in)
        given = f"distrusted {_metres(measured)}" if distrusted else f"in {_metres(depth_in)}"
        outside = session.frame.outside_view
        if outside is not None and outside[y, x]:
            given = "outside the depth camera's view"
        locked = " (locked)" if label in session.locked else ""
        parts = [f"x {x}, y {y}", f"{html.escape(block)}{locked}", given]
        past, error = self._workspace.past, session.expected_error()
        depth = session.present_depth() if past is None else past.depth
        if depth is not None:
            depth_out = float(depth[y, x])
            completion = session.completion()
            guessed = completion is not None and completion.guessed[y, x]
            if past is not None:
                parts.append(f"after iteration {past.iteration} {_metres(depth_out)}")
            else:
                parts.append(f"out {_metres(depth_out)}{' (guessed)' if guessed else ''}")
            if np.isfinite(depth_in) and np.isfinite(depth_out):
                parts.append(f"{1000 * (depth_out - depth_in):+.1f} mm")
        if past is None and error is not None and np.isfinite(error[y, x]):
            parts.append(f"\u00b1 {_error_text(float(error[y, x]))}")
            unvouched = session.unvouched()
            if unvouched is not None and unvouched[y, x]:
                parts.append("nothing vouches for it")
        runs = [f"{html.escape(kept.name)} {_metres(float(kept.completion.depth[y, x]))}" for kept in session.compared]
        return [*parts, *_judged(session, depth, x, y), *runs]


def _judged(session: Session, depth: NDArray[np.float32] | None, x: int, y: int) -> list[str]:
    """The truth, and how far off completed depth is."""
    truth = session.frame.truth
    if truth is None or not np.isfinite(truth[y, x]):
        return []
    parts = [f"truth {_metres(float(truth[y, x]))}"]
    if depth is not None and np.isfinite(depth[y, x]):
        parts.append(f"error {1000 * float(depth[y, x] - truth[y, x]):+.1f} mm")
    return parts


def _error_text(error: float) -> str:
    millimetres = 1000 * error
    return f"{millimetres:.{1 if millimetres < 10 else 0}f} mm" if error < 1 else f"{error:.2f} m"


def _metres(depth: float) -> str:
    return f"{depth:.3f} m" if np.isfinite(depth) else "missing"

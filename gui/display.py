"""Whether a window can be shown here, asked before Qt is, because Qt aborts where it cannot."""

from __future__ import annotations

import ctypes
import os
import sys

_PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libfontconfig.so.1": "libfontconfig1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libdbus-1.so.3": "libdbus-1-3",
    "libxkbcommon.so.0": "libxkbcommon0",
}
"""Libraries that Qt needs to start at all -> Debian and Ubuntu package."""

_X11_PACKAGES = {
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-xinerama.so.0": "libxcb-xinerama0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}
"""The same for windows under X11."""


def display_problem() -> str:
    """Why no window can be shown, with what to do about it; "" where one can, or Qt has been told what to use."""
    if not sys.platform.startswith("linux"):
        return ""
    missing = _missing(_PACKAGES)
    if missing:
        return _message(missing)
    if os.environ.get("QT_QPA_PLATFORM"):
        return ""
    if os.environ.get("WAYLAND_DISPLAY"):
        return ""
    if os.environ.get("DISPLAY"):
        return _message(_missing(_X11_PACKAGES))
    return "There is no display here (neither DISPLAY nor WAYLAND_DISPLAY is set), so no window can be shown."


def _missing(libraries: dict[str, str]) -> dict[str, str]:
    missing = {}
    for library, package in libraries.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing[library] = package
    return missing


def _message(missing: dict[str, str]) -> str:
    if not missing:
        return ""
    return (
        f"Qt cannot start because system libraries are missing: {', '.join(missing)}. "
        f"On Debian or Ubuntu: sudo apt install {' '.join(missing.values())}"
    )

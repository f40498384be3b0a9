"""Check that a window can be shown before Qt starts, because Qt aborts where it cannot."""

from __future__ import annotations

import ctypes
import os
import sys

from ilf._runtime.installation import how_to_install, missing_libraries

# libraries that Qt and its platform plugins link against, beyond the C and C++ run times and those that Qt ships;
# a test compares them with the installed Qt
QT_LIBRARIES = (
    "libEGL.so.1",
    "libGL.so.1",
    "libX11.so.6",
    "libdbus-1.so.3",
    "libfontconfig.so.1",
    "libfreetype.so.6",
    "libglib-2.0.so.0",
    "libgthread-2.0.so.0",
    "libxkbcommon.so.0",
    "libz.so.1",
    "libzstd.so.1",
)
"""Needed to start Qt, also without a display."""

PLATFORM_LIBRARIES = {
    "xcb": (
        "libX11-xcb.so.1",
        "libxcb.so.1",
        "libxcb-cursor.so.0",
        "libxcb-icccm.so.4",
        "libxcb-image.so.0",
        "libxcb-keysyms.so.1",
        "libxcb-randr.so.0",
        "libxcb-render.so.0",
        "libxcb-render-util.so.0",
        "libxcb-shape.so.0",
        "libxcb-shm.so.0",
        "libxcb-sync.so.1",
        "libxcb-util.so.1",
        "libxcb-xfixes.so.0",
        "libxcb-xkb.so.1",
        "libxkbcommon-x11.so.0",
    ),
    "wayland": ("libwayland-client.so.0", "libwayland-cursor.so.0", "libwayland-egl.so.1"),
    "offscreen": (),
}
"""Platform plugin -> libraries that its windows need in addition."""


def qt_problem() -> str:
    """Return why Qt cannot start, even without a display, and what to do; "" if it can."""
    return _problem(QT_LIBRARIES) if sys.platform.startswith("linux") else ""


def display_problem() -> str:
    """Return why no window can be shown, and what to do; "" if one can."""
    if not sys.platform.startswith("linux"):
        return ""
    platforms = _platforms()
    if not platforms:
        # what a display needs is named in the same round
        lacks = _problem(QT_LIBRARIES + PLATFORM_LIBRARIES["xcb"])
        return f"No window can be shown: there is no display. Set DISPLAY or WAYLAND_DISPLAY. {lacks}".rstrip()
    # one working platform is enough: Qt tries them in turn
    problems = [
        _problem(QT_LIBRARIES + PLATFORM_LIBRARIES.get(platform, ())) or (platform == "xcb" and _x11_problem()) or ""
        for platform in platforms
    ]
    return "" if "" in problems else problems[0]


def _platforms() -> list[str]:
    """Return the platform plugins that Qt would try: those in QT_QPA_PLATFORM, or else those with a display."""
    asked = os.environ.get("QT_QPA_PLATFORM")
    if asked:
        return [name.partition(":")[0] for name in asked.split(";")]
    displays = {"WAYLAND_DISPLAY": "wayland", "DISPLAY": "xcb"}
    return [platform for variable, platform in displays.items() if os.environ.get(variable)]


def _problem(libraries: tuple[str, ...]) -> str:
    missing = missing_libraries(libraries)
    return f"Qt cannot start because system libraries are missing: {how_to_install(missing)}." if missing else ""


def _x11_problem() -> str:
    """Return why the X server does not respond; checked with Xlib, because Qt aborts without a response."""
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    connection = x11.XOpenDisplay(None)
    if connection:
        x11.XCloseDisplay(ctypes.c_void_p(connection))
        return ""
    return (
        f"No window can be shown: the display {os.environ.get('DISPLAY', '')!r} does not respond or refuses this user. "
        "Check DISPLAY, or log in with ssh -X."
    )

"""Check that a window can be shown before Qt starts, because Qt aborts where it cannot."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from ilf._runtime.installation import how_to_install


def qt_problem() -> str:
    """Return why Qt cannot start, even without a display, and what to do; "" if it can."""
    return _problem("offscreen") if sys.platform.startswith("linux") else ""


def display_problem() -> str:
    """Return why no window can be shown, and what to do; "" if one can."""
    if not sys.platform.startswith("linux"):
        return ""
    platforms = _platforms()
    if not platforms:
        # what a display needs is named in the same round
        lacks = _problem("xcb")
        return f"No window can be shown: there is no display. Set DISPLAY or WAYLAND_DISPLAY. {lacks}".rstrip()
    # one working platform is enough: Qt tries them in turn
    problems = [_problem(platform) or (platform == "xcb" and _x11_problem()) or "" for platform in platforms]
    return "" if "" in problems else problems[0]


def _platforms() -> list[str]:
    """Return the platform plugins that Qt would try: those in QT_QPA_PLATFORM, or else those with a display."""
    asked = os.environ.get("QT_QPA_PLATFORM")
    if asked:
        return [name.partition(":")[0] for name in asked.split(";")]
    displays = {"WAYLAND_DISPLAY": "wayland", "DISPLAY": "xcb"}
    return [platform for variable, platform in displays.items() if os.environ.get(variable)]


def _problem(platform: str) -> str:
    """Return which libraries of the system the plugin of a platform lacks; "" for none, or if it cannot be told."""
    package, ldd = find_spec("PySide6"), shutil.which("ldd")
    if package is None or package.origin is None or ldd is None:
        return ""
    plugins = Path(package.origin).parent.glob(f"Qt/plugins/platforms/libq{platform}*.so")
    told = subprocess.run([ldd, *plugins], capture_output=True, text=True, check=False).stdout
    missing = dict.fromkeys(line.split()[0] for line in told.splitlines() if line.endswith("not found"))
    return f"Qt cannot start because system libraries are missing: {how_to_install([*missing])}." if missing else ""


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

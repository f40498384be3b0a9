"""What this program runs on: versions of everything that a report of a fault should name."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from PySide6.QtCore import qVersion

import ilf
from ilf._runtime.machine import library_versions

_WINDOW = {
    "PySide6": ("PySide6-Essentials", "PySide6"),
    "pyqtgraph": ("pyqtgraph",),
    "Open3D": ("open3d-cpu", "open3d"),
}
"""What only the window needs, by the name that users know -> the distributions that it may come from."""


def versions() -> dict[str, str]:
    """Versions by name; "not installed" of what is not there."""
    libraries = library_versions()
    known = {
        "ILF Studio": ilf.__version__,
        "Python": libraries.pop("python"),
        "Qt": qVersion(),
        **{{"opencv": "OpenCV"}.get(name, name): number for name, number in libraries.items()},
        **{name: _version(distributions) for name, distributions in _WINDOW.items()},
        "System": platform.platform(),
    }
    return {name: number or "not installed" for name, number in known.items()}


def versions_text() -> str:
    """The same, a line each."""
    return "\n".join(f"{name}: {number}" for name, number in versions().items())


def _version(distributions: tuple[str, ...]) -> str | None:
    for distribution in distributions:
        try:
            return version(distribution)
        except PackageNotFoundError:
            continue
    return None

"""Versions of the program, its libraries and the system, for bug reports."""

from __future__ import annotations

import platform

from PySide6.QtCore import qVersion

import ilf
from ilf.run.record import installed_version, library_versions

_DISPLAYED = {"opencv": "OpenCV", "onnxruntime": "ONNX Runtime"}

_WINDOW = {
    "PySide6": ("PySide6-Essentials", "PySide6"),
    "pyqtgraph": ("pyqtgraph",),
    "Open3D": ("open3d-cpu", "open3d"),
}
"""Libraries that only the window needs: display name -> distributions that may contain it."""


def versions() -> dict[str, str]:
    """Return versions by name; "not installed" for missing libraries."""
    libraries = library_versions()
    known = {
        "ILF Studio": ilf.__version__,
        "Python": libraries.pop("python"),
        "Qt": qVersion(),
        **{_DISPLAYED.get(name, name): number for name, number in libraries.items()},
        **{name: installed_version(*distributions) for name, distributions in _WINDOW.items()},
        "System": platform.platform(),
    }
    return {name: number or "not installed" for name, number in known.items()}


def versions_text() -> str:
    """Return the versions as text, one line each."""
    return "\n".join(f"{name}: {number}" for name, number in versions().items())

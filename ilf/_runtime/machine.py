"""Versions of libraries, and the processor: what a result may depend on besides the run."""

from __future__ import annotations

import importlib.metadata
import platform

import cv2
import numpy as np

# library that computes or writes results -> distributions that may contain it
_DISTRIBUTIONS = {
    "numpy": ("numpy",),
    "scipy": ("scipy",),
    "onnxruntime": ("onnxruntime", "onnxruntime-gpu", "onnxruntime-directml"),
    "opencv": (
        "opencv-python-headless",
        "opencv-python",
        "opencv-contrib-python",
        "opencv-contrib-python-headless",
    ),
    "numba": ("numba",),
}


def library_versions() -> dict[str, str | None]:
    """Return versions of Python and of the libraries that a result may depend on; None if not installed."""
    versions: dict[str, str | None] = {"python": platform.python_version()}
    for library, distributions in _DISTRIBUTIONS.items():
        found = list(filter(None, map(_version, distributions)))
        # if several are installed, all share the module installed last
        imported = cv2.__version__ if library == "opencv" else ""
        versions[library] = next(
            (version for version in found if version.startswith(imported)), next(iter(found), None)
        )
    return versions


def processor() -> str:
    """Return the processor architecture and the SIMD extensions that numpy uses; they may change the last digits."""
    found = np.show_config(mode="dicts") or {}
    extensions = found.get("SIMD Extensions", {})
    return " ".join([platform.machine(), *extensions.get("baseline", []), *extensions.get("found", [])])


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None

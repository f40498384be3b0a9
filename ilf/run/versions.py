"""Versions of libraries, and the processor: what a result may depend on besides the run."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

import cv2
import numpy as np


def installed_version(*distributions: str) -> str | None:
    """The version of the first of some distributions that is installed; None if none is."""
    for name in distributions:
        try:
            return version(name)
        except PackageNotFoundError:
            continue
    return None


def library_versions() -> dict[str, str | None]:
    """Return versions of Python and of the libraries that a result may depend on; None if not installed."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": installed_version("scipy"),
        "onnxruntime": installed_version("onnxruntime", "onnxruntime-gpu", "onnxruntime-directml"),
        "opencv": cv2.__version__,
        "numba": installed_version("numba"),
    }


def processor() -> str:
    """Return the processor architecture and the SIMD extensions that numpy uses; they may change the last digits."""
    found = np.show_config(mode="dicts") or {}
    extensions = found.get("SIMD Extensions", {})
    return " ".join([platform.machine(), *extensions.get("baseline", []), *extensions.get("found", [])])

"""What a result may depend on beside the run itself: libraries and processor."""

from __future__ import annotations

import importlib.metadata
import platform

import cv2
import numpy as np

# what computes or writes the results -> the distributions that may hold it
_DISTRIBUTIONS = {
    "numpy": ("numpy",),
    "scipy": ("scipy",),
    "opencv": (
        "opencv-python-headless",
        "opencv-python",
        "opencv-contrib-python",
        "opencv-contrib-python-headless",
    ),
    "scikit-image": ("scikit-image",),
    "numba": ("numba",),
}


def library_versions() -> dict[str, str | None]:
    """Versions of Python and of the libraries that a result may depend on; None for what is not installed."""
    versions: dict[str, str | None] = {"python": platform.python_version()}
    for library, distributions in _DISTRIBUTIONS.items():
        found = list(filter(None, map(_version, distributions)))
        # where several are installed, all of them are the one module that came last
        imported = cv2.__version__ if library == "opencv" else ""
        versions[library] = next(
            (version for version in found if version.startswith(imported)), next(iter(found), None)
        )
    return versions


def processor() -> str:
    """Kind of the processor and its extensions that numpy uses: with others, the last digits may differ."""
    found = np.show_config(mode="dicts") or {}
    extensions = found.get("SIMD Extensions", {})
    return " ".join([platform.machine(), *extensions.get("baseline", []), *extensions.get("found", [])])


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None

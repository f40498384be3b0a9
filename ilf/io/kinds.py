"""Kinds of files, by their first bytes or their suffix, for messages about those that are not read."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileSource
from ..errors import FormatError

COMMON_IMAGES = "a PNG, JPEG, TIFF, PGM or PPM image"

_AS_IMAGE = "Save it as PNG or JPEG if it is colour, as 16-bit PNG, TIFF or NPY if it is depth."
_AS_ARRAY = "Save its values as NPY (numpy.save), or as 16-bit PNG or TIFF."
_AS_FRAMES = (
    "Export colour and depth of its frames as images, or record as ROS bag (.bag, .db3, .mcap), Azure Kinect (.mkv) or "
    "Record3D (.r3d)."
)
UNPACK = "Unpack it, and give the files in it."
_HEIC = "an HEIC photo"
_PAGE = "It is often the error page of a download: then download the file again."

RAW_NUMBERS = "numpy.save(NEW, numpy.fromfile(FILE, TYPE).reshape(HEIGHT, WIDTH))"
"""How numbers without a header become NPY; `offset=` leaves out a header."""

_BY_START: tuple[tuple[bytes, str, str], ...] = (
    (rb"version https://git-lfs", "a Git LFS pointer", "Fetch the file itself: git lfs pull."),
    (rb"(?i)\s*<(!doctype html|html|!--|head|body)", "an HTML page", _PAGE),
    (rb"RIFF....WEBP", "a WebP image", _AS_IMAGE),
    (rb"RIFF....AVI ", "an AVI video", _AS_FRAMES),
    (rb"GIF8", "a GIF image", _AS_IMAGE),
    (rb"BM....\0\0\0\0", "a BMP image", _AS_IMAGE),
    (rb"....ftypavi[fs]", "an AVIF image", _AS_IMAGE),
    (rb"....ftyp(hei|hev|mif1|msf1)", _HEIC, "Rename it to .heic."),
    (rb"....ftyp", "an MP4 or QuickTime video", _AS_FRAMES),
    (rb"\xff\x0a|\0\0\0\x0cJXL ", "a JPEG XL image", _AS_IMAGE),
    (rb"\0\0\0\x0cjP  |\xff\x4f\xff\x51", "a JPEG 2000 image", _AS_IMAGE),
    (rb"\x89PNG", "a PNG image", "Rename it to .png."),
    (rb"\xff\xd8\xff", "a JPEG image", "Rename it to .jpg."),
    (rb"II\*\0|MM\0\*|II\+\0|MM\0\+", "a TIFF image", "Rename it to .tif."),
    (rb"8BPS", "a Photoshop image", _AS_IMAGE),
    (rb"DDS ", "a DDS image", _AS_IMAGE),
    (rb"#\?RADIANCE|#\?RGBE", "a Radiance HDR image", _AS_IMAGE),
    (rb"v/1\x01", "an OpenEXR image", "Rename it to .exr."),
    (rb"P[fF]\s", "a PFM image", "Rename it to .pfm."),
    (rb"P[14]\s", "a PBM image of one bit", _AS_IMAGE),
    (rb"P7\s", "a PAM image", _AS_IMAGE),
    (rb"P[2356]\s", "a PGM or PPM image", "Rename it to .pgm or .ppm."),
    (rb"PIEH", "a depth map or flow of Sintel", f"Save depth as NPY, with TYPE '<f4' and offset=12: {RAW_NUMBERS}."),
    (rb"\x93NUMPY", "an NPY array", "Rename it to .npy."),
    (rb"\x89HDF", "an HDF5 file", "Rename it to .h5."),
    (rb"MATLAB 7\.3", "a MATLAB file (7.3)", "Rename it to .mat."),
    (rb"MATLAB 5", "a MATLAB file (5)", "Save it with -v7.3, or as NPY."),
    (rb"%PDF", "a PDF document", _AS_IMAGE),
    (rb"PLYF|ply\s", "a PLY cloud", "Depth is read from clouds as organised PCD. Save it so, or as an image."),
    (rb"\x1aE\xdf\xa3", "a Matroska or WebM video", _AS_FRAMES),
    (rb"\x1f\x8b", "a gzip archive", UNPACK),
    (rb"\x28\xb5\x2f\xfd", "a file compressed by zstd", UNPACK),
    (rb"BZh|\xfd7zXZ|7z\xbc\xaf|Rar!", "an archive", UNPACK),
    (rb"\x80[\x02-\x05]", "a Python pickle", _AS_ARRAY),
    (rb"\s*<(\?xml|svg)", "an XML or SVG file", f"{_AS_IMAGE} {_PAGE}"),
    (rb'\s*[\[{]\s*["\[{\]}\d-]', "a JSON file", f"{_AS_ARRAY} {_PAGE}"),
    (rb"[\s\d.,;eE+-]{8,}(nan|inf)?[\s\d.,;eE+-]*", "a table as text (CSV)", _AS_ARRAY),
)
"""Pattern of the first bytes, kind, and what to do."""

_BY_SUFFIX = {
    **dict.fromkeys((".svo", ".svo2"), ("a ZED recording (.svo)", _AS_FRAMES)),
    **dict.fromkeys((".oni", ".klg", ".xef", ".rrd"), ("a recording of an unsupported kind", _AS_FRAMES)),
    **dict.fromkeys((".mp4", ".mov", ".avi", ".webm"), ("a video", _AS_FRAMES)),
    **dict.fromkeys((".csv", ".tsv"), ("a table as text (CSV)", _AS_ARRAY)),
    **dict.fromkeys((".mat", ".pkl", ".pt", ".pth"), ("an array of another program", _AS_ARRAY)),
    **dict.fromkeys((".dng", ".nef", ".cr2", ".arw", ".raf"), ("a raw photo", _AS_IMAGE)),
}
"""Suffix -> kind, and what to do, of files that are not known by their first bytes."""

_CONTAINERS: tuple[tuple[bytes, str, str], ...] = (
    (rb"#ROSBAG|\x89MCAP|SQLite format 3", "a recording", "Give it alone, with its suffix (.bag, .mcap, .db3)."),
    (rb"PK\x03\x04", "a zip archive", "If it is an NPZ, rename it to .npz; otherwise unpack it."),
    (rb"[\t\n\r\x20-\x7e]{8,}\Z", "a text file", "Check that it is the right file."),
)
"""As `_BY_START`, for what may contain anything, so that a suffix says more."""

_NAME = re.compile("[A-Z][A-Z0-9]{2,}")
"""A format's name in its kind."""

_LONGEST_START = 64


def kind_of_file(file: FileSource, data: bytes | NDArray[np.uint8]) -> tuple[str, str] | None:
    """The kind of a file, with its article, and what to do where it is not read; None if unknown.

    Parameters
    ----------
    file : path-like or FileContent
    data : bytes or ndarray of uint8
        Its content, or the beginning of it.
    """
    start = data[:_LONGEST_START]
    start = (start if isinstance(start, bytes) else start.tobytes()).removeprefix(b"\xef\xbb\xbf")
    return (
        _by_start(_BY_START, start) or _BY_SUFFIX.get(Path(str(file)).suffix.lower()) or _by_start(_CONTAINERS, start)
    )


def _by_start(table: tuple[tuple[bytes, str, str], ...], start: bytes) -> tuple[str, str] | None:
    """The kind and what to do of the first row of a table that fits."""
    return next(((kind, remedy) for sign, kind, remedy in table if re.match(sign, start, re.DOTALL)), None)


def kind_at(path: Path) -> tuple[str, str] | None:
    """The kind of the file at a path, as `kind_of_file`; None also if it cannot be read."""
    start = start_of(path)
    return None if start is None else kind_of_file(path, start)


def start_of(path: str | os.PathLike[str]) -> bytes | None:
    """The first bytes of the file at a path; None if it cannot be read."""
    try:
        if not os.path.isfile(path):  # a pipe would block
            return None
        with open(path, "rb") as stream:
            return stream.read(_LONGEST_START)
    except (OSError, ValueError):
        return None


def check_is_there(path: Path) -> None:
    """Raise FormatError for a Git LFS pointer, or a page of the web, in the place of a file."""
    found = kind_at(path)
    if found is not None and found in {_BY_START[0][1:], _BY_START[1][1:]}:
        raise FormatError(f"{path} is {found[0]}, not the file itself. {found[1]}")


def wrong_kind(file: FileSource, data: bytes | NDArray[np.uint8], wanted: str) -> FormatError:
    """The error for a file that is not `wanted`, naming its kind."""
    found = kind_of_file(file, data)
    if found is None:
        told = f"{file} is not {wanted}: its content is of an unknown kind. Copy or export it again"
        return FormatError(f"{told}, or, if it has numbers alone (ETH3D), save these as NPY: {RAW_NUMBERS}.")
    kind, remedy = found
    if remedy.startswith("Rename"):
        if (name := _NAME.search(kind)) and name[0] in wanted:
            if Path(str(file)).suffix.lower() in re.findall(r"\.\w+", remedy):
                return FormatError(f"{file} begins as {kind}, but is damaged. Copy or export it again.")
            return FormatError(f"{file} is {kind}, which is read under another suffix. {remedy}")
        if wanted == COMMON_IMAGES and kind != _HEIC:
            remedy = "Give the colour image: if this is depth, the two were swapped."
    return FormatError(f"{file} is {kind}, not {wanted}. {remedy}")

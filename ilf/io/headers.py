"""What an image file says about itself, format, size and orientation, before anything is decoded.

The decoder reports nothing but "no", would allocate whatever a header asks for, and takes a PNG whose checksums do not
fit, so these are looked at first, by Pillow, which reads no pixels for that.
"""

from __future__ import annotations

import io
import re
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from PIL import Image, TiffImagePlugin

from ..errors import FormatError
from .files import FileSource

_KINDS = ("PNG", "JPEG", "TIFF", "PPM")
_MAGIC = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"II", b"MM", b"P2", b"P3", b"P5", b"P6")
_BIG_TIFF = (b"II+\0", b"MM\0+")
_TIFF_ORIENTATION = 274
_CIELAB = {8, 9, 10}
"""Values of a TIFF's tag PhotometricInterpretation: CIELAB, ICCLAB, ITULAB."""

_PNM = re.compile(rb"P[2356]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d+)")
_WAY_OUT = "Copy or export it again, as PNG or TIFF."

# Pillow's limit and what it warns of belong to the whole process
_pillow = threading.Lock()


@dataclass(frozen=True)
class ImageHeader:
    """Format name, size in pixels as stored, the orientation tag of a TIFF (1: as stored), the largest value that a PGM
    or PPM declares (None: that of the decoded type), and whether a TIFF holds CIELAB colour."""

    kind: str
    width: int
    height: int
    orientation: int = 1
    largest: int | None = None
    is_cielab: bool = False


def image_header(path: FileSource, data: bytes) -> ImageHeader:
    """Read the header of a PNG, JPEG, TIFF, PGM or PPM file.

    Parameters
    ----------
    path : path-like or FileContent
        Named in messages.
    data : bytes
        Content of the file.

    Raises
    ------
    FormatError
        If it is none of these, or its header is truncated or damaged.
    """
    if not data.startswith(_MAGIC):
        raise FormatError(f"{path}: this is not a PNG, JPEG, TIFF or PGM image, whatever its name says. {_WAY_OUT}")
    if data.startswith(_BIG_TIFF):
        raise FormatError(f"{path}: this kind of TIFF (BigTIFF) is not supported. Save it as a classic TIFF.")
    with _reading(path, "its header gives no image size, or not all of it is there"):
        if data[:2] in (b"II", b"MM"):
            return _tiff(data)
        with Image.open(io.BytesIO(data), formats=_KINDS) as image:
            return ImageHeader(str(image.format), *image.size, largest=_declared(data))


def _declared(data: bytes) -> int | None:
    """The largest value that a PGM or PPM declares; None for others, and where the decoder has scaled by it."""
    found = _PNM.match(data)
    if found is None or (data[:2] in (b"P2", b"P3") and int(found[3]) <= 255):
        return None
    return int(found[3])


def check_checksums(path: FileSource, data: bytes) -> None:
    """Raise FormatError for a PNG that is cut short or whose checksums do not fit; other formats have none."""
    with _reading(path, "its end is missing or a checksum does not fit"):
        Image.open(io.BytesIO(data), formats=("PNG",)).verify()


@contextmanager
def _reading(path: FileSource, problem: str) -> Iterator[None]:
    """Let Pillow read without a limit of its own and without a word; whatever it raises becomes one FormatError."""
    with _pillow, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of tags that mean nothing to it
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        except Exception as error:
            raise FormatError(f"{path}: the file is truncated or damaged: {problem}. {_WAY_OUT}") from error
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _tiff(data: bytes) -> ImageHeader:
    """The first directory's tags only: `Image.open` knows fewer kinds of pixels than the decoder."""
    stream = io.BytesIO(data)
    tags = TiffImagePlugin.ImageFileDirectory_v2(stream.read(8))
    stream.seek(tags.next)
    tags.load(stream)
    width, height = int(tags[TiffImagePlugin.IMAGEWIDTH]), int(tags[TiffImagePlugin.IMAGELENGTH])
    if min(width, height) < 1:
        raise ValueError("no size")
    is_cielab = tags.get(TiffImagePlugin.PHOTOMETRIC_INTERPRETATION) in _CIELAB
    return ImageHeader("TIFF", width, height, int(tags.get(_TIFF_ORIENTATION, 1)), is_cielab=is_cielab)

"""Image files as arrays, exactly as stored: colour, label maps and masks."""

from __future__ import annotations

import io
import math
import re
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, TiffImagePlugin

from .._runtime.files import FileContent, FileSource, read_file
from .._runtime.memory import check_memory
from ..data.arrays import check_shape, plain_array
from ..errors import ExportError, FormatError, InputError
from .float_images import PFM_SUFFIX
from .hdf5 import HDF5_SUFFIXES, is_of_matlab, read_hdf5_colour
from .heic import HEIC_SUFFIXES, heic_orientation, read_heic_colour
from .kinds import COMMON_IMAGES, wrong_kind
from .pcl_files import PCD_SUFFIX, PCLZF_SUFFIX, read_pcd_colour, read_pclzf_colour

# Headers of image files: format, size and orientation, read before anything is decoded.
#
# The decoder reports failures without a reason, would allocate any size that a header declares, and accepts a PNG with
# wrong checksums. So these are checked first, by Pillow, which reads no pixels for that.

_KINDS = ("PNG", "JPEG", "TIFF", "PPM")
_MAGIC = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"II", b"MM", b"P2", b"P3", b"P5", b"P6")
_BIG_TIFF = (b"II+\0", b"MM\0+")
_ORIENTATION = 274
_PALETTE = 3
_CIELAB = {8, 9, 10}
"""Values of a TIFF's tag PhotometricInterpretation: CIELAB, ICCLAB, ITULAB."""

_PNM = re.compile(rb"P[2356]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d+)")
_COMMENT = re.compile(rb"#[^\n]*")
_SUBFILE, _OF_ANOTHER = 254, 0b101
"""A TIFF's tag NewSubfileType, and its bits for a smaller version of another image, or a mask of it."""

_REMEDY = "Copy or export it again, as PNG or TIFF."

# Pillow's limit and warning filters are global to the process
_pillow = threading.Lock()


@dataclass(frozen=True)
class ImageHeader:
    """Format name, size in pixels as stored, orientation tag (1: as stored), the maximum value declared by a PGM or PPM
    (None: that of the decoded type), whether a TIFF contains CIELAB colour, whether the image has a palette, and
    whether another one of its size follows."""

    kind: str
    width: int
    height: int
    orientation: int = 1
    largest: int | None = None
    is_cielab: bool = False
    has_palette: bool = False
    is_stack: bool = False


def image_header(path: FileSource, data: bytes) -> ImageHeader:
    """Read the header of a PNG, JPEG, TIFF, PGM or PPM file.

    Parameters
    ----------
    path : path-like or FileContent
        File for messages.
    data : bytes
        Content of the file.

    Raises
    ------
    FormatError
        If it is of none of these formats, its header is truncated or damaged, or it is a stack of images.
    """
    if not is_common_image(data):
        raise wrong_kind(path, data, COMMON_IMAGES)
    if data.startswith(_BIG_TIFF):
        raise FormatError(f"{path}: this kind of TIFF (BigTIFF) is not supported. Save it as a classic TIFF.")
    with _reading(path, "its header has no image size, or is incomplete"):
        if data[:2] not in (b"II", b"MM"):
            with Image.open(io.BytesIO(data), formats=_KINDS) as image:
                has_tags = image.format == "JPEG" or b"eXIf" in data or b"Orientation" in data
                tag = _orientation(image) if has_tags else 1
                return ImageHeader(str(image.format), *image.size, tag, _declared(data), has_palette=image.mode == "P")
        header = _tiff(data)
    if header.is_stack:
        raise FormatError(f"{path}: this TIFF contains several images of one size. Export each to a file of its own.")
    return header


def _orientation(image: Image.Image) -> int:
    """The orientation tag in EXIF or XMP; 1 if there is none, or its data are damaged."""
    try:
        return int(image.getexif().get(_ORIENTATION, 1))
    except Exception:  # Pillow raises all kinds for damaged EXIF, which matters for nothing else
        return 1


def is_common_image(data: bytes) -> bool:
    """Whether content begins like one of the formats that `image_header` reads."""
    return data.startswith(_MAGIC)


def _declared(data: bytes) -> int | None:
    """Return the maximum value declared by a PGM or PPM; None for others."""
    found = _PNM.match(data)
    return None if found is None else int(found[3])


@contextmanager
def _reading(path: FileSource, problem: str) -> Iterator[None]:
    """Let Pillow read without its size limit and without warnings; turn any exception into a FormatError."""
    with _pillow, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about unknown tags
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        except Exception as error:
            raise FormatError(f"{path}: the file is truncated or damaged: {problem}. {_REMEDY}") from error
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _tiff(data: bytes) -> ImageHeader:
    """Read only the tags of the first directory: `Image.open` supports fewer pixel types than the decoder."""
    stream = io.BytesIO(data)
    tags = TiffImagePlugin.ImageFileDirectory_v2(stream.read(8))
    stream.seek(tags.next)
    tags.load(stream)
    width, height = int(tags[TiffImagePlugin.IMAGEWIDTH]), int(tags[TiffImagePlugin.IMAGELENGTH])
    if min(width, height) < 1:
        raise ValueError("no size")
    meaning = tags.get(TiffImagePlugin.PHOTOMETRIC_INTERPRETATION)
    tag, is_stack = int(tags.get(_ORIENTATION, 1)), False
    if tags.next:
        following = TiffImagePlugin.ImageFileDirectory_v2(data[:8])
        stream.seek(tags.next)
        following.load(stream)
        size = following.get(TiffImagePlugin.IMAGEWIDTH), following.get(TiffImagePlugin.IMAGELENGTH)
        is_stack = size == (width, height) and not following.get(_SUBFILE, 0) & _OF_ANOTHER
    return ImageHeader("TIFF", width, height, tag, None, meaning in _CIELAB, meaning == _PALETTE, is_stack)


_DARK_BITS = 12
"""16-bit colour with at most this many used bits would be nearly black."""

# the decoder's log level is global to the process
_decoding = threading.Lock()

_UPRIGHT: dict[int, Callable[[NDArray[Any]], NDArray[Any]]] = {
    2: np.fliplr,
    3: lambda image: np.rot90(image, 2),
    4: np.flipud,
    5: lambda image: image.swapaxes(0, 1),
    6: lambda image: np.rot90(image, -1),
    7: lambda image: np.rot90(image, 2).swapaxes(0, 1),
    8: np.rot90,
}
"""Orientation tag -> how viewers turn the stored image."""


_OPPOSITE = {6: 8, 8: 6}
"""Orientation tag -> the one that turns back, where that is another one."""

Tags = tuple[int, int]
"""Orientation tags of colour and depth."""

AS_STORED: Tags = 1, 1
"""Orientations of colour and depth that are not turned."""


def orientation_claim(file: FileContent) -> tuple[int, str]:
    """The orientation by which a file may have to be turned, and why; 1 and "" if there is no sign of it."""
    suffix = file.path.suffix.lower()
    if suffix in HDF5_SUFFIXES and not is_of_matlab(file):
        return 5, f"{file.path.name} may be stored column by column, as MATLAB's h5write does"
    if suffix == PFM_SUFFIX:
        return 4, f"{file.path.name} may be stored from its top row on, as AirSim's write_pfm does"
    if suffix in HEIC_SUFFIXES:
        tag = heic_orientation(file)
        back = f"{file.path.name} is shown upright, not as stored, by its orientation tag {tag}, which may be undone"
        return _OPPOSITE.get(tag, tag), back if tag in _UPRIGHT else ""
    try:
        tag = image_header(file, file.data.tobytes()).orientation
    except FormatError:  # of a format without such tags
        tag = 1
    return (tag, f"{file.path.name} has the orientation tag {tag}") if tag in _UPRIGHT else (1, "")


def turned(image: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Turn an image as its orientation tag tells viewers to."""
    return np.ascontiguousarray(_UPRIGHT[orientation](image)) if orientation in _UPRIGHT else image


def read_image(path: FileSource) -> NDArray[Any]:
    """Read the pixels of a PNG, JPEG, TIFF, PGM or PPM file as stored, never rotated.

    Orientation tags are ignored: `ilf.io.orientation` decides for both images of a pair whether they apply.

    Returns
    -------
    ndarray
        (H, W), or (H, W, channels) in BGR order; any dtype that the format supports.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it is truncated, damaged, of another format, or too large.
    """
    return _decoded(path)[0]


_FRACTIONS = {
    8: cv2.IMREAD_REDUCED_COLOR_8,
    4: cv2.IMREAD_REDUCED_COLOR_4,
    2: cv2.IMREAD_REDUCED_COLOR_2,
    1: cv2.IMREAD_UNCHANGED,
}
"""Whole size / size that a JPEG is decoded at -> how. Smaller ones take a fraction of the time."""


def _decoded(path: FileSource, least_width: int = 0) -> tuple[NDArray[Any], ImageHeader]:
    data = read_file(path).data
    content = data.tobytes()
    header = image_header(path, content)
    check_memory(path, header.width, header.height)
    if header.kind == "PNG":
        with _reading(path, "its end is missing or a checksum is wrong"):
            Image.open(io.BytesIO(content), formats=("PNG",)).verify()
    if content.startswith((b"P2", b"P3")):
        return _of_text(path, content, header), header
    factors = _FRACTIONS if least_width and header.kind == "JPEG" else (1,)
    factor = next((one for one in factors if header.width >= one * least_width), 1)
    image = without_log(lambda: cv2.imdecode(data, _FRACTIONS[factor] | cv2.IMREAD_IGNORE_ORIENTATION))
    if image is not None and header.kind == "TIFF":  # whose decoder applies the tag, whatever its flags
        image = turned(image, _OPPOSITE.get(header.orientation, header.orientation))
    if image is None or image.shape[:2] != (-(-header.height // factor), -(-header.width // factor)):
        raise FormatError(f"{path}: this {header.kind} is truncated, damaged, or of an unsupported kind. {_REMEDY}")
    return image, header


def _of_text(path: FileSource, content: bytes, header: ImageHeader) -> NDArray[Any]:
    """The values of a PGM or PPM whose values are text, as `read_image` returns them."""
    found, largest = _PNM.match(content), header.largest or 0
    shape = (header.height, header.width, 3) if content.startswith(b"P3") else (header.height, header.width)
    with _reading(path, "its values are not as its header declares"):
        if found is None or not 0 < largest < 2**16:
            raise ValueError("no header")
        words = _COMMENT.sub(b"", content[found.end() :]).split(maxsplit=math.prod(shape))
        values = np.array(words[: math.prod(shape)]).astype(np.int64).reshape(shape)
        if values.min() < 0 or values.max() > largest:
            raise ValueError("out of range")
    image = values.astype(np.uint8 if largest < 2**8 else np.uint16)
    return image if image.ndim == 2 else np.ascontiguousarray(image[..., ::-1])


def read_indices(path: FileSource) -> NDArray[Any]:
    """Read the values of a label map or mask as `read_image`, but the indices of a palette in place of its colours, and
    grey of less than 8 bits as stored, not scaled to 8; raises FormatError as it does, and for JPEG."""
    content = read_file(path)
    image, header = _decoded(content)
    if header.kind == "JPEG":
        raise FormatError(f"{path}: JPEG changes labels and masks. Save the original as PNG.")
    data = content.data.tobytes()
    if header.has_palette and (header.kind == "PNG" or header.orientation == 1):
        with _reading(path, "its indices cannot be decoded"), Image.open(io.BytesIO(data), formats=_KINDS) as indexed:
            return np.asarray(indexed, np.uint8)
    if header.kind == "PNG" and data[_PNG_BITS] < 8:
        return image // (255 // (2 ** data[_PNG_BITS] - 1))
    return image


_PNG_BITS = 24
"""Place of the number of bits in a PNG."""


def read_colour(path: FileSource, least_width: int = 0) -> NDArray[np.uint8]:
    """Read a colour image as uint8 (H, W, 3), RGB.

    16-bit values are scaled to 8 bits (65535 -> 255), those of a PGM or PPM from its declared maximum; grey is repeated
    in all channels, alpha is dropped. With `least_width` [px], a JPEG that is much wider is read at a half, quarter or
    eighth of its size, which is faster.

    Raises
    ------
    InputError, FormatError
        As `read_image`; FormatError also for floating-point or signed images, and for CIELAB.
    """
    return read_colour_with_warning(path, least_width)[0]


def read_colour_with_warning(path: FileSource, least_width: int = 0) -> tuple[NDArray[np.uint8], str]:
    """Read a colour image as `read_colour`, and return it with a plausibility warning about how it was read; "" if
    there is none."""
    content = read_file(path)
    if reader := _COLOUR_READERS.get(content.path.suffix.lower()):
        return reader(content), ""
    image, header = _decoded(content, least_width)
    if header.is_cielab:
        raise FormatError(f"{path}: this TIFF contains CIELAB colour, not RGB. Export it as RGB.")
    doubt = _few_bits(image) if header.largest is None else ""
    if image.dtype == np.uint16 or (image.dtype == np.uint8 and header.largest not in (None, 255)):
        image = _eight_bits(image, header.largest or np.iinfo(image.dtype).max)
    if image.dtype != np.uint8:
        told = f"{path}: colour must have 8 or 16 bits per channel, but this has {image.dtype} values"
        raise FormatError(f"{told}. If this is the depth, colour and depth were given in the wrong order.")
    if image.ndim == 2:
        image = image[..., None]
    if image.shape[2] not in {1, 3, 4}:
        raise FormatError(f"{path}: colour must have 1, 3 or 4 channels, not {image.shape[2]}. Export it as RGB.")
    blue_first = image[..., :3]
    return np.ascontiguousarray(np.broadcast_to(blue_first[..., ::-1], (*image.shape[:2], 3))), doubt


_COLOUR_READERS = {
    PCD_SUFFIX: read_pcd_colour,
    PCLZF_SUFFIX: read_pclzf_colour,
    **dict.fromkeys(HEIC_SUFFIXES, read_heic_colour),
    **dict.fromkeys(HDF5_SUFFIXES, read_hdf5_colour),
}
"""Suffix -> reader of colour from files that are no common images."""


def _eight_bits(image: NDArray[Any], largest: int) -> NDArray[np.uint8]:
    """Scale values from 0 to `largest` to 0 to 255."""
    scaled = (np.arange(np.iinfo(image.dtype).max + 1) * 255 + largest // 2) // largest
    return np.minimum(scaled, 255).astype(np.uint8)[image]


def _few_bits(image: NDArray[Any]) -> str:
    """Return a plausibility warning if 16-bit colour uses fewer bits; "" otherwise."""
    brightest = int(image.max()) if image.dtype == np.uint16 else 0
    bits = max(brightest.bit_length(), 8)
    if not brightest or bits > _DARK_BITS:
        return ""
    told = f"Colour is nearly black: its maximum value is {brightest} of 65535, as of {bits} bits per channel"
    return f"{told}. Multiply its values by {2 ** (16 - bits)}, or export it with 8 bits."


def scaled_colour(rgb: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Resize colour (h, w, 3) to (height, width), by area averages if it becomes smaller; unchanged if it has that
    size.

    Raises
    ------
    InputError
        If the two sizes have different aspect ratios.
    """
    if rgb.shape[:2] == shape:
        return rgb
    if not math.isclose(shape[0], shape[1] / rgb.shape[1] * rgb.shape[0], abs_tol=1.0):
        sizes = f"Colour is {rgb.shape[1]} x {rgb.shape[0]} and depth is {shape[1]} x {shape[0]}"
        raise InputError(f"{sizes}, of another aspect ratio: they do not show the same view.")
    how = cv2.INTER_AREA if rgb.shape[0] >= shape[0] else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(rgb, shape[::-1], interpolation=how), np.uint8)


def encode_image(suffix: str, image: NDArray[Any]) -> bytes:
    """Encode an image in the format of `suffix` (".png", ".tif"); equal pixels give equal bytes."""
    return cv2.imencode(suffix, image)[1].tobytes()


def without_log(decode: Callable[[], NDArray[Any] | None]) -> NDArray[Any] | None:
    """Run the decoder without its log on stderr; None if it fails."""
    with _decoding:
        level = cv2.utils.logging.getLogLevel()
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        try:
            return decode()
        except cv2.error:
            return None
        finally:
            cv2.utils.logging.setLogLevel(level)


# Label maps, as PNG with 16 bits, and masks, with 8.


def encode_mask(mask: NDArray[np.bool_]) -> bytes:
    """Return a mask (H, W) as 8-bit PNG, 255 where it is True."""
    return encode_image(".png", 255 * plain_array(mask).astype(np.uint8))


def read_mask(path: FileSource, shape: tuple[int, int] | None = None) -> NDArray[np.bool_]:
    """Read a mask from an image with one channel of 8 or 16 bits, bool (H, W): True where it is not 0.

    Parameters
    ----------
    path : path-like or FileContent
    shape : (int, int), optional
        Required (H, W).

    Raises
    ------
    InputError, FormatError
        As `read_labels`.
    """
    return read_labels(path, shape, what="mask") > 0


def encode_labels(labels: ArrayLike) -> bytes:
    """Return a label map as PNG; raises ExportError if the labels do not fit into 16 bits."""
    return encode_image(".png", checked_for_writing(labels).astype(np.uint16))


def checked_for_writing(labels: ArrayLike) -> NDArray[np.int32]:
    """Return the label map as int32 (H, W); raise ExportError if it is invalid, or does not fit into 16 bits."""
    array = plain_array(labels)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iu":
        raise ExportError(f"Labels must be integers with shape (H, W), not {array.dtype} {array.shape}.")
    if array.min() < 0 or array.max() > 65535:
        raise ExportError(f"Labels to write must be 0 to 65535, not {array.min()} to {array.max()}. Renumber them.")
    return array.astype(np.int32)


def read_labels(
    path: FileSource, shape: tuple[int, int] | None = None, *, what: str = "label map"
) -> NDArray[np.int32]:
    """Read a label map from a PNG with 8 or 16 bits, int32 (H, W); 0 = no block. The labels of a PNG with a palette are
    its indices.

    Parameters
    ----------
    path : path-like or FileContent
    shape : (int, int), optional
        Required (H, W).
    what : str
        Its name in messages.

    Raises
    ------
    InputError
        If the file does not exist or its size differs from `shape`.
    FormatError
        If it is damaged or not a label map.
    """
    image = read_indices(path)
    if image.ndim != 2 or image.dtype.kind != "u" or image.dtype.itemsize > 2:
        wanted = f"{path}: a {what} must have one channel with 8 or 16 bits, not {image.dtype} {image.shape}"
        raise FormatError(f"{wanted}. Export the values themselves, not a coloured image of them.")
    if shape is not None:
        check_shape(f"{path}: the {what}", image.shape, shape, remedy=f"Use the {what} of this frame.")
    return image.astype(np.int32)

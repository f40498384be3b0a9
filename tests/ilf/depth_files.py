"""Contents of image and depth files, also in formats that only tests write."""

import io
import struct

import numpy as np
import pytest
from PIL import Image


def npy(values: np.ndarray, **options: object) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values, **options)
    return stream.getvalue()


def npz(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def exr(channels: dict[str, np.ndarray], **header: object) -> bytes:
    openexr = pytest.importorskip("OpenEXR")
    kind = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    stream = io.BytesIO()
    openexr.File({**kind, **header}, channels).write(stream)
    return stream.getvalue()


def pfm(values: np.ndarray, scale: str = "-1.0", kind: bytes = b"Pf") -> bytes:
    order = "<f4" if scale.startswith("-") else ">f4"
    return kind + b"\n%d %d\n" % values.shape[1::-1] + scale.encode() + b"\n" + values[::-1].astype(order).tobytes()


def colmap(values: np.ndarray, channels: int = 1) -> bytes:
    return b"%d&%d&%d&" % (*values.shape[1::-1], channels) + values.astype("<f4").tobytes()


def lzf(data: bytes) -> bytes:
    """LZF of literal runs alone."""
    return b"".join(bytes([len(run) - 1]) + run for run in (data[at : at + 32] for at in range(0, len(data), 32)))


def pclzf(kind: str, data: bytes, width: int, height: int) -> bytes:
    packed = lzf(data)
    return struct.pack("<5s2I16s2I", b"PCLZF", width, height, kind.ljust(16).encode(), len(packed), len(data)) + packed


def pcd(kind: str, depth: np.ndarray, colour: np.ndarray) -> bytes:
    """An organised cloud of depth [m] and colour, whose x and y are 0, with two labels a point."""
    fields = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<f4"), ("label", "<u2", (2,))])
    points = np.zeros(depth.size, fields)
    points["z"] = depth.ravel()
    red, green, blue = (colour[..., channel].astype(np.uint32).ravel() for channel in range(3))
    points["rgb"] = (red << 16 | green << 8 | blue).view(np.float32)
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb label\nSIZE 4 4 4 4 2\n"
        f"TYPE F F F F U\nCOUNT 1 1 1 1 2\nWIDTH {depth.shape[1]}\nHEIGHT {depth.shape[0]}\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {depth.size}\nDATA {kind}\n"
    ).encode()
    if kind == "ascii":
        lines = (f"{p['x']} {p['y']} {p['z']} {p['rgb']:.9e} 0 0" for p in points)
        return header + "\n".join(lines).encode()
    if kind == "binary":
        return header + points.tobytes()
    columns = b"".join(np.ascontiguousarray(points[name]).tobytes() for name in fields.names)
    packed = lzf(columns)
    return header + struct.pack("<2I", len(packed), len(columns)) + packed


def pillow(image: Image.Image | np.ndarray, kind: str, **options: object) -> bytes:
    """An image in one of Pillow's formats."""
    stream = io.BytesIO()
    (Image.fromarray(image) if isinstance(image, np.ndarray) else image).save(stream, kind, **options)
    return stream.getvalue()

"""Small valid recordings and float depth files from the tests' writers."""

import io
from pathlib import Path

import numpy as np
import OpenEXR

from tests.ilf import phone_files
from tests.ilf.bags import path_of, storage_of, write_aligned
from tests.ilf.depth_files import colmap, exr, npz, pfm
from tests.ilf.matroska import write_azure
from tests.ilf.realsense_bags import write_library_db3, write_viewer_bag
from tests.ilf.two_cameras import write_pair

from .seeds import Seeds, depth_values, with_colour

ARKIT_CAMERA = f"4242/lowres_wide_intrinsics/4242_{phone_files.TIMES[0]:.3f}.pincam"


def _metres() -> np.ndarray:
    return (depth_values() / 1000).astype(np.float32)


def depth_exr(folder: Path) -> list[bytes]:
    """With several compressions."""
    with_colour(folder)
    packings = OpenEXR.ZIP_COMPRESSION, OpenEXR.NO_COMPRESSION, OpenEXR.PIZ_COMPRESSION, OpenEXR.RLE_COMPRESSION
    return [exr({"Z": _metres()}, compression=packing) for packing in packings]


def depth_pfm(folder: Path) -> list[bytes]:
    """In both byte orders."""
    with_colour(folder)
    return [pfm(_metres()), pfm(_metres(), "1")]


def depth_colmap(folder: Path) -> list[bytes]:
    """A depth map of COLMAP."""
    with_colour(folder)
    return [colmap(_metres())]


def depth_npz(folder: Path) -> list[bytes]:
    """One array or several."""
    with_colour(folder)
    several = io.BytesIO()
    np.savez(several, depth=_metres(), other=np.zeros(3))
    return [npz(arr_0=_metres()), several.getvalue()]


def bag(kind: str) -> Seeds:
    """A recording of ROS 1, or the file of one of ROS 2."""

    def made(folder: Path) -> list[bytes]:
        write_aligned(folder, kind, frames=2, name="sound")
        return [(storage_of if kind != "ros1" else path_of)(folder, kind, "sound").read_bytes()]

    return made


def ros2(folder: Path) -> None:
    """A recording of ROS 2, with its metadata.yaml."""
    write_aligned(folder, "sqlite3", frames=2, name="made")


def realsense_viewer(folder: Path) -> None:
    """Of the RealSense Viewer, until 2.58."""
    write_viewer_bag(folder, name="made")


def realsense_library(folder: Path) -> list[bytes]:
    """Of the RealSense library since 2.59."""
    return [write_library_db3(folder, "sound").read_bytes()]


def nyu_raw(folder: Path) -> None:
    """A pair of NYU Depth's raw folders."""
    (folder / "raw").mkdir()
    (folder / "raw" / "r-1.5-1.ppm").write_bytes(b"P6\n640 480\n255\n" + bytes(3 * 640 * 480))
    depth = np.full(640 * 480, 700, "<u2").tobytes()
    (folder / "raw" / "d-1.5-2.pgm").write_bytes(b"P5\n640 480\n65535\n" + depth)


def raw_pair(folder: Path) -> None:
    """A user's raw pair, with its calibration.json."""
    write_pair(folder / "pair")


def azure(folder: Path) -> None:
    """Of an Azure Kinect."""
    write_azure(folder / "made.mkv", frames=1)


def record3d(folder: Path) -> None:
    """A .r3d."""
    phone_files.write_record3d(folder / "made.r3d")


def scannet(folder: Path) -> list[bytes]:
    """A .sens."""
    return [phone_files.sens(count=2)]


def stray(folder: Path) -> None:
    """A folder of Stray Scanner."""
    phone_files.write_stray(folder / "stray")


def arkit(folder: Path) -> None:
    """A sequence of ARKitScenes."""
    phone_files.write_arkit(folder / "4242")

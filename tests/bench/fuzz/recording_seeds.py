"""Small valid recordings and float depth files from the tests' writers."""

import io
from pathlib import Path

import numpy as np
import OpenEXR

from tests.ilf import phone_files
from tests.ilf.bags import path_of, storage_of, write_aligned
from tests.ilf.matroska import write_azure
from tests.ilf.realsense_bags import write_library_db3, write_viewer_bag
from tests.ilf.two_cameras import write_pair

from .seeds import Seeds, depth_values, with_colour

ARKIT_CAMERA = f"lowres_wide_intrinsics/4242_{phone_files.TIMES[0]:.3f}.pincam"


def _metres() -> np.ndarray:
    return (depth_values() / 1000).astype(np.float32)


def depth_exr(folder: Path) -> list[bytes]:
    """With several compressions."""
    with_colour(folder)
    contents = []
    for packing in (OpenEXR.ZIP_COMPRESSION, OpenEXR.NO_COMPRESSION, OpenEXR.PIZ_COMPRESSION, OpenEXR.RLE_COMPRESSION):
        stream = io.BytesIO()
        OpenEXR.File({"compression": packing, "type": OpenEXR.scanlineimage}, {"Z": _metres()}).write(stream)
        contents.append(stream.getvalue())
    return contents


def depth_pfm(folder: Path) -> list[bytes]:
    """In both byte orders."""
    with_colour(folder)
    rows = _metres()[::-1]
    head = b"Pf\n%d %d\n" % rows.shape[::-1]
    return [head + b"-1.0\n" + rows.astype("<f4").tobytes(), head + b"1\n" + rows.astype(">f4").tobytes()]


def depth_colmap(folder: Path) -> list[bytes]:
    """A depth map of COLMAP."""
    with_colour(folder)
    return [b"%d&%d&1&" % _metres().shape[::-1] + _metres().astype("<f4").tobytes()]


def depth_npz(folder: Path) -> list[bytes]:
    """One array or several."""
    with_colour(folder)
    one, several = io.BytesIO(), io.BytesIO()
    np.savez_compressed(one, _metres())
    np.savez(several, depth=_metres(), other=np.zeros(3))
    return [one.getvalue(), several.getvalue()]


def bag(kind: str) -> Seeds:
    """A recording of ROS 1, or the file of one of ROS 2."""

    def made(folder: Path) -> list[bytes]:
        write_aligned(folder, kind, frames=2, name="sound")
        return [(storage_of if kind != "ros1" else path_of)(folder, kind, "sound").read_bytes()]

    return made


def metadata(folder: Path) -> list[bytes]:
    """metadata.yaml of a recording of ROS 2."""
    return [(write_aligned(folder, "sqlite3", frames=2, name="sound") / "metadata.yaml").read_bytes()]


def realsense_viewer(folder: Path) -> list[bytes]:
    """Of the RealSense Viewer, until 2.58."""
    return [write_viewer_bag(folder, name="sound").read_bytes()]


def realsense_library(folder: Path) -> list[bytes]:
    """Of the RealSense library since 2.59."""
    return [write_library_db3(folder, "sound").read_bytes()]


def nyu_raw(file: str) -> Seeds:
    """One of the two files of a pair of NYU Depth's raw folders."""

    def made(folder: Path) -> list[bytes]:
        content = {
            "r-1.5-1.ppm": b"P6\n640 480\n255\n" + bytes(3 * 640 * 480),
            "d-1.5-2.pgm": b"P5\n640 480\n65535\n" + np.full(640 * 480, 700, "<u2").tobytes(),
        }
        (folder / "raw").mkdir()
        for name in content:
            (folder / "raw" / name).write_bytes(content[name])
        return [content[file]]

    return made


def raw_pair(folder: Path) -> list[bytes]:
    """The calibration.json of a user's raw pair."""
    write_pair(folder / "pair")
    return [(folder / "pair" / "calibration.json").read_bytes()]


def azure(folder: Path) -> list[bytes]:
    """Of an Azure Kinect."""
    return [write_azure(folder / "sound.mkv", frames=1).read_bytes()]


def record3d(folder: Path) -> list[bytes]:
    """A .r3d."""
    return [phone_files.write_record3d(folder / "sound.r3d").read_bytes()]


def scannet(folder: Path) -> list[bytes]:
    """A .sens."""
    return [phone_files.sens(count=2)]


def stray(file: str) -> Seeds:
    """One of the files of a folder of Stray Scanner."""

    def made(folder: Path) -> list[bytes]:
        return [(phone_files.write_stray(folder / "stray") / file).read_bytes()]

    return made


def arkit_camera(folder: Path) -> list[bytes]:
    """The camera of a frame of ARKitScenes."""
    return [(phone_files.write_arkit(folder / "4242") / ARKIT_CAMERA).read_bytes()]


def arkit(file: str) -> Seeds:
    """One of the files of a sequence of ARKitScenes."""

    def made(folder: Path) -> list[bytes]:
        return [(phone_files.write_arkit(folder / "4242") / file).read_bytes()]

    return made

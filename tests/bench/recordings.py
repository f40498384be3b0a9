"""Speed of reading frames of recordings: python -m tests.bench.recordings [FILE...]

Writes the bundled room as paired files and as recordings of every kind, 60 frames of 640 x 480 each (Azure Kinect:
1280 x 720 and 640 x 576), and prints the time of listing, stored and registered frames per second (both also for
FILEs), and the ratio to paired PNG files. Seconds are processor time of one thread.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf._runtime.installation import asset_path
from ilf.sources.opening import close_all
from tests.ilf.bags import bag, compressed_depth, path_of
from tests.ilf.matroska import write_azure

FRAMES = 60


def _written(folder: Path) -> dict[str, Path]:
    """Recordings by name."""
    frame = ilf.load_frame(asset_path("samples/room"))
    depth = np.rint(np.nan_to_num(frame.depth) * 1000).astype(np.uint16)
    rgb, bgr = frame.rgb, np.ascontiguousarray(frame.rgb[..., ::-1])
    for name, image in (("rgb", bgr), ("depth", depth)):
        (folder / "files" / name).mkdir(parents=True)
        for number in range(FRAMES):
            cv2.imwrite(str(folder / "files" / name / f"{number:04d}.png"), image)
    jpeg = cv2.imencode(".jpg", bgr)[1].tobytes()
    found = {"paired PNG files": folder / "files"}
    for kind in ("ros1", "sqlite3", "mcap"):
        for packed in (False, True):
            name = f"{kind}-{'packed' if packed else 'raw'}"
            with bag(folder, kind, name) as out:
                for number in range(FRAMES):
                    stamp = number * 33_000_000
                    if packed:
                        out.compressed("/c/color/image_raw/compressed", jpeg, "rgb8; jpeg compressed bgr8", stamp)
                        data = compressed_depth(depth)
                        out.compressed(
                            "/c/aligned_depth_to_color/image_raw/compressedDepth", data, "16UC1; compressedDepth", stamp
                        )
                    else:
                        out.image("/c/color/image_raw", rgb, "rgb8", stamp)
                        out.image("/c/aligned_depth_to_color/image_raw", depth, "16UC1", stamp)
            found[f"{kind}, {'JPEG and compressedDepth' if packed else 'raw images'}"] = path_of(folder, kind, name)
    found["Azure Kinect, MJPG 720p"] = write_azure(folder / "azure.mkv", FRAMES, depth_mode="NFOV_UNBINNED")
    return found


def _seconds(do: Callable[[], object]) -> float:
    started = time.process_time()
    do()
    return time.process_time() - started


def main(files: list[str]) -> None:
    """Print the table."""
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        plain = 0.0
        for name, path in (_written(Path(folder)) | {Path(file).name: Path(file) for file in files}).items():
            close_all()
            opened: list[ilf.Source] = []
            listing = _seconds(lambda path=path, opened=opened: opened.append(ilf.open_source(path)))
            source = opened[0]
            sources = [source.frame_source(key) for key in source.keys]
            stored = _seconds(lambda sources=sources: [one.read_depth() for one in sources]) / len(source)
            whole = _seconds(lambda sources=sources: [one.load() for one in sources]) / len(source)
            plain = plain or whole
            print(
                f"{name:35} listed in {listing:6.3f} s, {1 / stored:6.1f} stored and {1 / whole:6.1f} whole frames/s, "
                f"{plain / whole:5.2f} of paired files"
            )
    close_all()


if __name__ == "__main__":
    main(sys.argv[1:])

"""Small recordings in the layouts of Record3D, Stray Scanner, ARKitScenes, ScanNet and NYU Depth's labelled file."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

SIZE, COLOUR_SIZE = (32, 24), (64, 48)
COUNT = 3
MM = (1500 + 7 * np.arange(SIZE[0])[None] + 20 * np.arange(SIZE[1])[:, None]).astype(np.uint16)
MM[3:6, 10:16] = 0
LEVELS = np.full(MM.shape, 2, np.uint8)
LEVELS[:, :8] = 0
LEVELS[:, 8:12] = 1
K = (60.0, 60.0, 31.5, 23.5)
"""Of colour; that of depth is half of it, about the corner of the first pixel."""
DEPTH_K = (30.0, 30.0, 15.5, 11.5)
TIMES = tuple(100.0 + number / 10 for number in range(COUNT))
TURN = Rotation.from_euler("xyz", [0.1, -0.2, 0.3])
POSE = np.eye(4)
POSE[:3, :3], POSE[:3, 3] = TURN.as_matrix(), [0.5, -1.0, 2.0]
"""Of the first frame's camera, x right, y down, z forward; the others lie 0.1 m further along x each."""
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


def colour(number: int, size: tuple[int, int] = COLOUR_SIZE) -> np.ndarray:
    """Grey that rises with the frame's number; blue first."""
    return np.full((size[1], size[0], 3), 40 + 60 * number, np.uint8)


def pose(number: int) -> np.ndarray:
    """Of a frame's camera."""
    found = POSE.copy()
    found[0, 3] += 0.1 * number
    return found


def encoded(suffix: str, image: np.ndarray) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


def write_record3d(path: Path, **metadata: object) -> Path:
    """A .r3d; metadata that are None are left out."""
    import lzfse

    in_opengl = [pose(number) @ FLIP for number in range(COUNT)]
    known: dict[str, object] = {
        **dict(zip(("w", "h", "dw", "dh"), (*COLOUR_SIZE, *SIZE), strict=True)),
        "K": [K[0], 0, 0, 0, K[1], 0, K[2], K[3], 1],
        "fps": 10,
        "frameTimestamps": TIMES,
        "poses": [[*Rotation.from_matrix(one[:3, :3]).as_quat(), *one[:3, 3]] for one in in_opengl],
    }
    with zipfile.ZipFile(path, "w") as archive:
        said = {name: value for name, value in {**known, **metadata}.items() if value is not None}
        archive.writestr("metadata", json.dumps(said))
        for number in range(COUNT):
            archive.writestr(f"rgbd/{number}.jpg", encoded(".jpg", colour(number)))
            metres = np.where(MM > 0, MM / 1000, np.nan).astype("<f4")
            archive.writestr(f"rgbd/{number}.depth", lzfse.compress(metres.tobytes()))
            archive.writestr(f"rgbd/{number}.conf", lzfse.compress(LEVELS.tobytes()))
    return path


def write_stray(folder: Path, codec: str = "libx264") -> Path:
    """A folder of Stray Scanner; its video has H.264 in the place of HEVC unless another codec is given."""
    import av

    for name in ("depth", "confidence"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    with av.open(str(folder / "rgb.mp4"), "w") as container:
        stream = container.add_stream(codec, rate=10)
        stream.width, stream.height, stream.pix_fmt = *COLOUR_SIZE, "yuv420p"
        for number in range(COUNT):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(colour(number), format="bgr24")))
        container.mux(stream.encode(None))
    lines = ["timestamp, frame, x, y, z, qx, qy, qz, qw"]
    for number in range(COUNT):
        cv2.imwrite(str(folder / "depth" / f"{number:06}.png"), MM)
        cv2.imwrite(str(folder / "confidence" / f"{number:06}.png"), LEVELS)
        turned = Rotation.from_matrix(pose(number)[:3, :3]).as_quat()
        lines.append(", ".join(map(str, (TIMES[number], f"{number:06}", *pose(number)[:3, 3], *turned))))
    (folder / "odometry.csv").write_text("\n".join(lines) + "\n")
    (folder / "camera_matrix.csv").write_text(f"{K[0]}, 0.0, {K[2]}\n0.0, {K[1]}, {K[3]}\n0.0, 0.0, 1.0\n")
    return folder


def write_arkit(folder: Path, colours: str = "lowres_wide", size: tuple[int, int] = SIZE) -> Path:
    """A sequence of ARKitScenes."""
    for name in (colours, "lowres_depth", "confidence", f"{colours}_intrinsics"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    lines = []
    numbers = K if size == COLOUR_SIZE else DEPTH_K
    for number, time in enumerate(TIMES):
        name = f"4242_{time:.3f}"
        cv2.imwrite(str(folder / colours / f"{name}.png"), colour(number, size))
        cv2.imwrite(str(folder / "lowres_depth" / f"{name}.png"), MM)
        cv2.imwrite(str(folder / "confidence" / f"{name}.png"), LEVELS)
        (folder / f"{colours}_intrinsics" / f"{name}.pincam").write_text(" ".join(map(str, (*size, *numbers))))
        to_camera = np.linalg.inv(pose(number))
        axis = Rotation.from_matrix(to_camera[:3, :3]).as_rotvec()
        lines.append(" ".join(map(str, (time + 0.0004, *axis, *to_camera[:3, 3]))))
    (folder / "lowres_wide.traj").write_text("\n".join(lines) + "\n")
    return folder


def sens(depth_place: np.ndarray | None = None, count: int = COUNT) -> bytes:
    """Content of a .sens; the depth camera stands where colour's does unless it is told."""
    matrices = []
    for numbers, place in ((K, np.eye(4)), (DEPTH_K, np.eye(4) if depth_place is None else depth_place)):
        matrix = np.eye(4)
        matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2] = numbers
        matrices += [matrix, place]
    content = struct.pack("<IQ", 4, 4) + b"made"
    content += b"".join(struct.pack("<16f", *matrix.ravel()) for matrix in matrices)
    content += struct.pack("<2i4IfQ", 2, 1, *COLOUR_SIZE, *SIZE, 1000.0, count)
    for number in range(COUNT):
        rgb, depth = encoded(".jpg", colour(number)), zlib.compress(MM.tobytes())
        microseconds = round(TIMES[number] * 1e6)
        content += struct.pack("<16f4Q", *pose(number).ravel(), microseconds, microseconds, len(rgb), len(depth))
        content += rgb + depth
    return content


def write_nyu(path: Path) -> Path:
    """A labelled file of NYU Depth V2, with three small frames."""
    import h5py

    with h5py.File(path, "w") as file:
        rgb = np.stack([colour(number, SIZE)[..., ::-1].transpose(2, 1, 0) for number in range(COUNT)])
        metres = np.stack([MM.T / 1000] * COUNT).astype(np.float32)
        file["images"] = rgb
        file["rawDepths"] = metres
        file["depths"] = np.where(metres > 0, metres, 1.6).astype(np.float32)
    return path

"""Small recordings in the layouts of Record3D, Stray Scanner, ARKitScenes, ScanNet and NYU Depth's labelled file."""

import json
import struct
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

Size = tuple[int, int]


@dataclass(frozen=True)
class Scene:
    """What is written: sizes (width, height) of depth and colour, and how many frames."""

    size: Size = (32, 24)
    colour_size: Size = (64, 48)
    count: int = 3

    @property
    def mm(self) -> np.ndarray:
        """A slope with a hole."""
        width, height = self.size
        found = (1500 + 224 * np.arange(width)[None] // width + 480 * np.arange(height)[:, None] // height).astype(
            "<u2"
        )
        found[height // 8 : height // 4, width // 3 : width // 2] = 0
        return found

    @property
    def levels(self) -> np.ndarray:
        """Confidence."""
        found = np.full(self.size[::-1], 2, np.uint8)
        found[:, : self.size[0] // 4] = 0
        found[:, self.size[0] // 4 : self.size[0] * 3 // 8] = 1
        return found

    @property
    def times(self) -> tuple[float, ...]:
        return tuple(100.0 + number / 10 for number in range(self.count))


SMALL = Scene()
SIZE, COLOUR_SIZE, COUNT = SMALL.size, SMALL.colour_size, SMALL.count
MM, LEVELS, TIMES = SMALL.mm, SMALL.levels, SMALL.times


def camera(size: Size) -> tuple[float, float, float, float]:
    """Its numbers for images of a size: of two sizes about the corner of the first pixel."""
    return 60 / 64 * size[0], 60 / 64 * size[0], size[0] / 2 - 0.5, size[1] / 2 - 0.5


K, DEPTH_K = camera(COLOUR_SIZE), camera(SIZE)
TURN = Rotation.from_euler("xyz", [0.1, -0.2, 0.3])
POSE = np.eye(4)
POSE[:3, :3], POSE[:3, 3] = TURN.as_matrix(), [0.5, -1.0, 2.0]
"""Of the first frame's camera, x right, y down, z forward; the others lie 0.1 m further along x each."""
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


def colour(number: int, size: Size = COLOUR_SIZE) -> np.ndarray:
    """Grey that rises with the frame's number; blue first."""
    return np.full((size[1], size[0], 3), (40 + 60 * number) % 256, np.uint8)


def pose(number: int) -> np.ndarray:
    """Of a frame's camera."""
    found = POSE.copy()
    found[0, 3] += 0.1 * number
    return found


def encoded(suffix: str, image: np.ndarray) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


def write_record3d(path: Path, scene: Scene = SMALL, **metadata: object) -> Path:
    """A .r3d; metadata that are None are left out."""
    import lzfse

    k = camera(scene.colour_size)
    in_opengl = [pose(number) @ FLIP for number in range(scene.count)]
    known: dict[str, object] = {
        **dict(zip(("w", "h", "dw", "dh"), (*scene.colour_size, *scene.size), strict=True)),
        "K": [k[0], 0, 0, 0, k[1], 0, k[2], k[3], 1],
        "fps": 10,
        "frameTimestamps": scene.times,
        "poses": [[*Rotation.from_matrix(one[:3, :3]).as_quat(), *one[:3, 3]] for one in in_opengl],
    }
    with zipfile.ZipFile(path, "w") as archive:
        said = {name: value for name, value in {**known, **metadata}.items() if value is not None}
        archive.writestr("metadata", json.dumps(said))
        for number in range(scene.count):
            archive.writestr(f"rgbd/{number}.jpg", encoded(".jpg", colour(number, scene.colour_size)))
            metres = np.where(scene.mm > 0, scene.mm / 1000, np.nan).astype("<f4")
            archive.writestr(f"rgbd/{number}.depth", lzfse.compress(metres.tobytes()))
            archive.writestr(f"rgbd/{number}.conf", lzfse.compress(scene.levels.tobytes()))
    return path


def write_stray(folder: Path, scene: Scene = SMALL, codec: str = "libx264") -> Path:
    """A folder of Stray Scanner; its video has H.264 in the place of HEVC unless another codec is given."""
    import av

    for name in ("depth", "confidence"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    with av.open(str(folder / "rgb.mp4"), "w") as container:
        stream = container.add_stream(codec, rate=10)
        stream.width, stream.height, stream.pix_fmt = *scene.colour_size, "yuv420p"
        for number in range(scene.count):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(colour(number, scene.colour_size), format="bgr24")))
        container.mux(stream.encode(None))
    lines = ["timestamp, frame, x, y, z, qx, qy, qz, qw"]
    for number in range(scene.count):
        cv2.imwrite(str(folder / "depth" / f"{number:06}.png"), scene.mm)
        cv2.imwrite(str(folder / "confidence" / f"{number:06}.png"), scene.levels)
        turned = Rotation.from_matrix(pose(number)[:3, :3]).as_quat()
        lines.append(", ".join(map(str, (scene.times[number], f"{number:06}", *pose(number)[:3, 3], *turned))))
    (folder / "odometry.csv").write_text("\n".join(lines) + "\n")
    k = camera(scene.colour_size)
    (folder / "camera_matrix.csv").write_text(f"{k[0]}, 0.0, {k[2]}\n0.0, {k[1]}, {k[3]}\n0.0, 0.0, 1.0\n")
    return folder


def write_arkit(folder: Path, colours: str = "lowres_wide", scene: Scene = Scene(SIZE, SIZE)) -> Path:
    """A sequence of ARKitScenes."""
    for name in (colours, "lowres_depth", "confidence", f"{colours}_intrinsics"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    lines = []
    for number, time in enumerate(scene.times):
        name = f"4242_{time:.3f}"
        cv2.imwrite(str(folder / colours / f"{name}.png"), colour(number, scene.colour_size))
        cv2.imwrite(str(folder / "lowres_depth" / f"{name}.png"), scene.mm)
        cv2.imwrite(str(folder / "confidence" / f"{name}.png"), scene.levels)
        (folder / f"{colours}_intrinsics" / f"{name}.pincam").write_text(
            " ".join(map(str, (*scene.colour_size, *camera(scene.colour_size))))
        )
        to_camera = np.linalg.inv(pose(number))
        axis = Rotation.from_matrix(to_camera[:3, :3]).as_rotvec()
        lines.append(" ".join(map(str, (time + 0.0004, *axis, *to_camera[:3, 3]))))
    (folder / "lowres_wide.traj").write_text("\n".join(lines) + "\n")
    return folder


def sens(depth_place: np.ndarray | None = None, count: int | None = None, scene: Scene = SMALL) -> bytes:
    """Content of a .sens; the depth camera stands where colour's does unless it is told."""
    matrices = []
    for numbers, place in (
        (camera(scene.colour_size), np.eye(4)),
        (camera(scene.size), np.eye(4) if depth_place is None else depth_place),
    ):
        matrix = np.eye(4)
        matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2] = numbers
        matrices += [matrix, place]
    content = struct.pack("<IQ", 4, 4) + b"made"
    content += b"".join(struct.pack("<16f", *matrix.ravel()) for matrix in matrices)
    content += struct.pack(
        "<2i4IfQ", 2, 1, *scene.colour_size, *scene.size, 1000.0, scene.count if count is None else count
    )
    for number in range(scene.count):
        rgb, depth = encoded(".jpg", colour(number, scene.colour_size)), zlib.compress(scene.mm.tobytes())
        microseconds = round(scene.times[number] * 1e6)
        content += struct.pack("<16f4Q", *pose(number).ravel(), microseconds, microseconds, len(rgb), len(depth))
        content += rgb + depth
    return content

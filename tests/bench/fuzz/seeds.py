"""Small valid files of every format, and their companion files."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np
import pillow_heif
from PIL import Image

import ilf
from ilf.data.presets import UserPreset, write_preset
from ilf.io.block_files import write_blocks
from ilf.project.file import save_project
from ilf.project.project import Project, ProjectFrame
from ilf.run.options import ExportOptions
from ilf.run.writing import write
from tests.ilf.depth_files import npy, pcd, pclzf, pillow
from tests.ilf.project_states import made_frame, rich_state, small_frame
from tests.ilf.tiny_onnx import message, node, number, write_network

HEIGHT, WIDTH = SHAPE = 24, 32

Seeds = Callable[[Path], list[bytes] | None]
"""Writes companion files into a folder, and returns valid contents of the file, or writes that, too."""

PROJECT = "room.ilf"


def depth_values() -> np.ndarray:
    """uint16 [mm] with a hole."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    depth = (1500 + 10 * rows + 7 * columns).astype(np.uint16)
    depth[5:10, 8:15] = 0
    return depth


def _colour() -> np.ndarray:
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return np.stack([rows * 8, columns * 7, (rows * columns) % 256], axis=-1).astype(np.uint8)


def _labels() -> np.ndarray:
    labels = np.zeros(SHAPE, np.uint16)
    labels[:, 4:16], labels[3:12, 18:] = 1, 700
    return labels


def _encoded(suffix: str, image: np.ndarray, *options: int) -> bytes:
    return cv2.imencode(suffix, image, list(options))[1].tobytes()


def with_colour(folder: Path, name: str = "rgb.png") -> None:
    """Write the colour image."""
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(_encoded(Path(name).suffix, _colour()))


def with_depth(folder: Path, name: str = "depth.png") -> None:
    """Write the depth image."""
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(_encoded(".png", depth_values()))


def depth_png(folder: Path) -> list[bytes]:
    """From two writers, with two compressions."""
    with_colour(folder)
    fixed = _encoded(".png", depth_values(), cv2.IMWRITE_PNG_STRATEGY, 4)
    return [_encoded(".png", depth_values()), fixed, pillow(depth_values(), "PNG")]


def depth_tiff(folder: Path) -> list[bytes]:
    """Integers and floats, uncompressed and compressed."""
    with_colour(folder)
    metres = (depth_values() / 1000).astype(np.float32)
    packed = [pillow(depth_values(), "TIFF", compression=name) for name in ("raw", "tiff_lzw", "tiff_adobe_deflate")]
    return [*packed, _encoded(".tif", metres), _encoded(".tif", metres, cv2.IMWRITE_TIFF_COMPRESSION, 1)]


def depth_pgm(folder: Path) -> list[bytes]:
    """Binary, with and without a comment, and as text."""
    with_colour(folder)
    values = depth_values()
    plain = _encoded(".pgm", values)
    text = f"P2 {values.shape[1]} {values.shape[0]} 65535\n{' '.join(map(str, values.ravel()))}\n"
    return [plain, plain.replace(b"P5\n", b"P5\n# made\n", 1), text.encode()]


def depth_npy(folder: Path) -> list[bytes]:
    """Several types and memory orders."""
    with_colour(folder)
    metres = depth_values() / 1000
    kinds = (depth_values(), metres.astype(np.float32), np.asfortranarray(metres), metres.astype(">f4"))
    return [npy(kind) for kind in kinds]


def depth_hdf5(folder: Path) -> list[bytes]:
    """HDF5 with one dataset, and MATLAB's, whose only one that can be depth has any name."""
    with_colour(folder)
    one, matlab = io.BytesIO(), folder / "matlab.mat"
    with h5py.File(one, "w") as file:
        file["dataset"] = (depth_values() / 1000).astype(np.float16)
    with h5py.File(matlab, "w", userblock_size=512) as file:
        file["scene/z"], file["K"] = depth_values().T, np.eye(3)
        file["scene/z"].attrs["MATLAB_class"] = np.bytes_("uint16")
    content = b"MATLAB 7.3 MAT-file".ljust(512) + matlab.read_bytes()[512:]
    matlab.unlink()
    return [one.getvalue(), content]


def depth_of_several(folder: Path) -> list[bytes]:
    """HDF5 with several datasets, compressed and not."""
    with_colour(folder)
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file.create_dataset("left/depth", data=depth_values(), compression="gzip", shuffle=True, chunks=(8, 8))
        file["right/z"], file["K"] = depth_values() / 1000, np.eye(3)
    return [stream.getvalue()]


def viewer(folder: Path) -> None:
    """A snapshot of the RealSense Viewer: depth, and its table."""
    with_colour(folder)
    table = f"Frame Info:\nType,Depth\nFormat,Z16\nResolution x,{WIDTH}\nResolution y,{HEIGHT}\n"
    (folder / "depth_metadata.csv").write_text(table)
    (folder / "depth.raw").write_bytes(depth_values().astype("<u2").tobytes())


def depth_pcd(folder: Path) -> list[bytes]:
    with_colour(folder)
    return [pcd(kind, depth_values() / 1000, _colour()) for kind in ("ascii", "binary", "binary_compressed")]


def depth_pclzf(folder: Path) -> list[bytes]:
    with_colour(folder)
    return [pclzf("depth16", depth_values().tobytes(), WIDTH, HEIGHT)]


def layout(folder: Path) -> list[bytes]:
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(exist_ok=True)
        (folder / kind / "1.png").touch()
    table = 'rgb = "{}/{rgb,color}/*.png"\ndepth = "{}/depth/*.png"\nunits = 1000\nK = "500,500,16,12"\n'
    return [table.encode(), f'[lab]\ntitle = "x"\n{table}pose_axes = "y-up"\nneeds = ["{{}}/depth/*"]\n'.encode()]


def transforms(folder: Path) -> list[bytes]:
    with_colour(folder, "transforms/rgb.png")
    with_depth(folder, "transforms/depth.png")
    frame = {"file_path": "rgb.png", "depth_file_path": "depth.png", "transform_matrix": np.eye(4).tolist()}
    camera = {"fl_x": 30.0, "fl_y": 30.0, "cx": 16.0, "cy": 12.0, "w": WIDTH, "h": HEIGHT}
    return [json.dumps({**camera, "depth_unit_scale_factor": 0.001, "frames": [frame]}).encode()]


def open3d_trajectory(folder: Path) -> list[bytes]:
    """trajectory.log of a folder of Open3D."""
    with_colour(folder, "frames/color/0.png")
    with_depth(folder, "frames/depth/0.png")
    return [b"0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0.5\n0 0 0 1\n"]


def intrinsics_text(folder: Path) -> list[bytes]:
    """As Open3D, people and others write them."""
    return [b"30 0 16\n0 30 12\n0 0 1\n", b"fx: 30\nfy: 30\ncx: 16\ncy: 12\n", b"32 24 30 30 16 12 0 0 0 0 0\n"]


def colour_png(folder: Path) -> list[bytes]:
    """RGB, grey, with a palette, with alpha."""
    with_depth(folder)
    grey, palette = _colour()[..., 0], Image.fromarray(_colour()).quantize(16)
    others = [_encoded(".png", image) for image in (_colour(), grey, np.dstack([_colour(), grey]))]
    return [*others, pillow(palette, "PNG")]


def colour_jpeg(folder: Path) -> list[bytes]:
    """Baseline, progressive, grey, turned by EXIF."""
    with_depth(folder)
    exif = Image.Exif()
    exif[274] = 6
    kinds = [_encoded(".jpg", _colour()), _encoded(".jpg", _colour(), cv2.IMWRITE_JPEG_PROGRESSIVE, 1)]
    return [*kinds, _encoded(".jpg", _colour()[..., 0]), pillow(_colour(), "JPEG", exif=exif)]


def colour_heic(folder: Path) -> list[bytes]:
    """A photo, and one with an orientation tag."""
    with_depth(folder)
    exif = Image.Exif()
    exif[274] = 6
    found = []
    for more in ({}, {"exif": exif.tobytes()}):
        stream = io.BytesIO()
        pillow_heif.from_pillow(Image.fromarray(_colour())).save(stream, **more)
        found.append(stream.getvalue())
    return found


def colour_ppm(folder: Path) -> list[bytes]:
    """TIFF and PPM under any name: the content determines the format."""
    with_depth(folder)
    return [_encoded(".ppm", _colour()), _encoded(".tif", _colour())]


def guide_npz(folder: Path) -> list[bytes]:
    """One or several arrays, compressed or not."""
    inverse = (1000 / (depth_values() + 1.0)).astype(np.float32)
    plain, packed = io.BytesIO(), io.BytesIO()
    np.savez(plain, inverse)
    np.savez_compressed(packed, disparity=inverse, other=np.zeros(3))
    return [plain.getvalue(), packed.getvalue()]


def meta_json(folder: Path) -> list[bytes]:
    """With every possible key."""
    with_colour(folder)
    with_depth(folder)
    camera = [30.0, 30.0, 15.5, 11.5]
    (folder / "gt.png").write_bytes(_encoded(".png", np.maximum(depth_values(), 1500)))
    (folder / "guide.npy").write_bytes(npy((depth_values() / 1000).astype(np.float32)))
    plain = {"size": [WIDTH, HEIGHT], "depth_units_per_m": 1000, "K": camera, "name": "made"}
    rich = {
        "depth_encoding": "mm", "depth_invalid": 65535, "K": [[30.0, 0, 15.5], [0, 30.0, 11.5], [0, 0, 1]],
        "rgb": "rgb.png", "depth": "depth.png", "gt": "gt.png", "gt_units_per_m": 1000.0, "guide": "guide.npy",
    }  # fmt: skip
    return [json.dumps(plain).encode(), json.dumps(rich).encode()]


def intrinsics_json(folder: Path) -> list[bytes]:
    """In all accepted forms."""
    forms: list[object] = [
        {"fx": 30.0, "fy": 30.0, "cx": 15.5, "cy": 11.5, "width": 64, "height": 48},
        {"K": [30.0, 30.0, 15.5, 11.5]},
        {"intrinsic_matrix": [30.0, 0, 0, 0, 30.0, 0, 15.5, 11.5, 1], "width": WIDTH, "height": HEIGHT},
        [[30.0, 0, 15.5], [0, 30.0, 11.5], [0, 0, 1]],
    ]
    turn = np.eye(3).tolist()
    place = {"rotationMatrix": turn, "translation": {"x": -7.5, "y": 0.0, "z": 0.0}, "toCameraSocket": 0}
    camera = {"intrinsicMatrix": [[30.0, 0, 15.5], [0, 30.0, 11.5], [0, 0, 1]], "width": 64, "height": 48}
    stereo = {"rightCameraSocket": 1, "rectifiedRotationRight": turn}
    sockets = [[0, camera], [1, camera | {"extrinsics": place}]]
    forms.append({"cameraData": sockets, "stereoRectificationData": stereo})
    forms.append({"depth": camera, "depth_to_color": {"rotation": turn, "translation_mm": [15.0, 0.0, 0.0]}})
    return [json.dumps(form).encode() for form in forms]


def intrinsics_yaml(folder: Path) -> list[bytes]:
    """As ROS, Kalibr and people write them, and lines of KITTI."""
    matrix = "[30.0, 0.0, 15.5, 0.0, 30.0, 11.5, 0.0, 0.0, 1.0]"
    ros = f"image_width: 32\nimage_height: 24\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: {matrix}\n"
    kalibr = "cam0: &a\n  camera_model: pinhole\n  intrinsics: [30, 30, 15.5, 11.5]\n  resolution: [32, 24]\ncam1: *a\n"
    rows = "[[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
    chain = (
        f"cam0:\n  intrinsics: [30, 30, 15.5, 11.5]\ncam1:\n  intrinsics: [30, 30, 15.5, 11.5]\n  T_cn_cnm1: {rows}\n"
    )
    numbers = "fx: 30.0  # px\nfy: 30.0\ncx: 15.5\ncy: 11.5\n"
    kitti = "S_02: 32 24\nK_02: 30 0 15.5 0 30 11.5 0 0 1\nD_02: 0.1 0 0 0 0\n"
    return [text.encode() for text in (ros, f"{ros}---\n{ros}", kalibr, chain, numbers, kitti)]


def preset(folder: Path) -> list[bytes]:
    """With and without parameters of blocks."""
    write_preset(folder / "a.json", UserPreset("soft", ilf.preset("best", smoothness=3)))
    other = UserPreset("other", ilf.preset("paper", max_iterations=7), ilf.BlockParameters(granularity=0.4))
    write_preset(folder / "b.json", other)
    return [(folder / name).read_bytes() for name in ("a.json", "b.json")]


def blocks(folder: Path, format: str) -> None:
    """One of the formats of `write_blocks`."""
    with_colour(folder)
    write_blocks(folder / "blocks.json", _labels(), format=format, names={1: "chair"}, image=folder / "rgb.png")


def label_map(folder: Path) -> list[bytes]:
    """16 and 8 bits, PNG and TIFF."""
    labels = _labels()
    small = np.minimum(labels, 9).astype(np.uint8)
    return [_encoded(".png", labels), _encoded(".png", small), _encoded(".tif", labels)]


def mask(folder: Path) -> list[bytes]:
    """Black and white."""
    return [_encoded(".png", np.where(_labels() > 0, 255, 0).astype(np.uint8))]


def project(folder: Path) -> None:
    """With a frame from files and one made by a program."""
    states = [rich_state(small_frame(folder / "frame"), "a1"), rich_state(made_frame(), "b2")]
    frames = tuple(ProjectFrame(state.id, state.frame.name, None, has_state=True) for state in states)
    save_project(folder / PROJECT, Project(frames), states)


def record(folder: Path) -> None:
    """Run record with every possible entry."""
    frame = small_frame(folder / "frame")
    drawn = np.zeros(frame.shape, bool)
    drawn[10:20, 39] = True
    run = ilf.Run.of(frame, preset=ilf.preset(max_iterations=3))
    run = ilf.Run(frame, ilf.Blocks(run.blocks.labels, own={1: {"smoothness": 2.0}}, drawn=drawn), run.parameters)
    write(folder / "out", run.complete(), ExportOptions(cloud="ply"))


def time_lists(folder: Path) -> list[bytes]:
    """Lists of colour and depth by time, as rgb.txt; depth.txt and the images are valid."""
    for frame in range(3):
        with_colour(folder, f"rgb/{frame}.png")
        with_depth(folder, f"depth/{frame}.png")
    lines = [f"{frame / 30:.6f} depth/{frame}.png" for frame in range(3)]
    (folder / "depth.txt").write_text("# depth\n" + "\n".join(lines))
    return ["\n".join(["# colour", *(f"{frame / 30:.6f} rgb/{frame}.png" for frame in range(3))]).encode()]


def associations(folder: Path) -> list[bytes]:
    """Colour and depth side by side."""
    time_lists(folder)
    (folder / "depth.txt").unlink()
    return ["\n".join(f"{i / 30:.6f} rgb/{i}.png {i / 30:.6f} depth/{i}.png" for i in range(3)).encode()]


def bop(folder: Path) -> list[bytes]:
    """scene_camera.json, with its images."""
    with_colour(folder, "rgb/000003.png")
    with_depth(folder, "depth/000003.png")
    camera = {"cam_K": [30.0, 0.0, 15.5, 0.0, 30.0, 11.5, 0.0, 0.0, 1.0], "depth_scale": 0.1}
    return [json.dumps({"3": camera, "4": camera | {"cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1]}}).encode()]


def sun(folder: Path) -> list[bytes]:
    """intrinsics.txt of SUN RGB-D."""
    with_colour(folder, "image/0.jpg")
    with_depth(folder, "depth/0.png")
    return [b"30.0 0 15.5\n0 30.0 11.5\n0 0 1\n"]


def trajectory(folder: Path) -> list[bytes]:
    """groundtruth.txt of TUM's benchmark."""
    return [b"# time tx ty tz qx qy qz qw\n0.5 1 2 3 0 0 0 1\n0.51 1 2 3.1 0 0.1 0 0.99\n0.52 1 2 3.1 0.1 0 0 0.99\n"]


def pose(folder: Path) -> list[bytes]:
    """A matrix, as in 7-Scenes."""
    return [b"1 0 0 0.5\n0 1 0 -1\n0 0 1 2e0\n0 0 0 1\n"]


def onnx(folder: Path) -> list[bytes]:
    """Networks with several operations."""
    mean = node("ReduceMean", ["image"], "strength", axes=[1], keepdims=1)
    pooled = node("MaxPool", ["image"], "pooled", kernel_shape=[3, 3], strides=[1, 1], pads=[1, 1, 1, 1])
    largest = node("ReduceMax", ["pooled"], "sum", axes=[1], keepdims=1)
    weights = number(1, 1) + number(1, 3) + number(1, 3) + number(1, 3) + number(2, 1) + message(8, "w")
    weights += message(9, np.full(27, 0.01, "<f4").tobytes())
    convolved = node("Conv", ["image", "w"], "sum", kernel_shape=[3, 3], pads=[1, 1, 1, 1])
    sigmoid = node("Sigmoid", ["sum"], "strength")
    networks = (([mean], b""), ([pooled, largest, sigmoid], b""), ([convolved, sigmoid], weights))
    return [write_network(folder / "w", nodes, weights=given).read_bytes() for nodes, given in networks]


def nyu_labelled(folder: Path) -> list[bytes]:
    """Two frames, uncompressed and in compressed chunks."""
    contents = []
    for options in ({}, {"compression": "gzip", "shuffle": True, "chunks": True}):
        path = folder / "sound.mat"
        with h5py.File(path, "w", userblock_size=512) as file:
            colour, depth = _colour().transpose(2, 1, 0)[None], (depth_values().T / 1000).astype(np.float32)[None]
            for name, array in (("images", colour), ("depths", depth + 1), ("rawDepths", depth)):
                file.create_dataset(name, data=np.repeat(array, 2, axis=0), **options)
        contents.append(path.read_bytes())
    return contents


def mask_picture(folder: Path) -> list[bytes]:
    """One of the masks of a folder."""
    (folder / "masks").mkdir()
    picture = mask(folder)[0]
    for name in ("0", "1", "chair"):
        (folder / "masks" / f"{name}.png").write_bytes(picture)
    return [picture]


def confidence_png(folder: Path) -> list[bytes]:
    """Levels of 8 and 16 bits."""
    levels = np.where(_labels() > 0, 2, 0).astype(np.uint8)
    return [_encoded(".png", levels), _encoded(".png", levels.astype(np.uint16) * 300)]


def confidence_npy(folder: Path) -> list[bytes]:
    """Integers, floats and booleans."""
    levels = np.where(_labels() > 0, 2, 0)
    return [npy(levels.astype(kind)) for kind in (np.uint8, np.float32, bool, np.int64)]


def guide_npy(folder: Path) -> list[bytes]:
    """Values with and without a confidence."""
    metres = (depth_values() / 1000).astype(np.float32)
    return [npy(metres), npy(np.stack([metres, np.full_like(metres, 0.5)]))]


def guide_png(folder: Path) -> list[bytes]:
    """Grey with one channel, with three, and at twice the size."""
    grey = (depth_values() >> 4).astype(np.uint8)
    large = np.repeat(np.repeat(depth_values(), 2, 0), 2, 1)
    return [_encoded(".png", image) for image in (depth_values(), np.dstack([grey] * 3), large)]


def window(folder: Path) -> list[bytes]:
    """Settings of a closed window."""
    from .window import settings  # creates a window

    return settings(folder)


def scheduler(folder: Path) -> list[bytes]:
    """The scheduler file of Dask."""
    said = {"type": "Scheduler", "id": "Scheduler-0", "address": "tcp://127.0.0.1:8786", "services": {}, "workers": {}}
    return [json.dumps(said).encode()]


def names(folder: Path) -> list[bytes]:
    """Names of colour and depth in all supported pairings; the files are valid."""
    with_colour(folder)
    with_depth(folder)
    times = [f"1305031102.{number:06}" for number in range(3)]
    forms = (
        ("rgb/{}.png", "depth/{}.png", ("0001", "2", "10")),
        ("color/{}.jpg", "depth/{}.png", times),
        ("image/{}.png", "depth/{}.png", ("1305031102175304", "1305031102175304123", "1305031102175")),
        ("{}_rgb.png", "{}_depth.png", ("a1", "a2")),
        ("room{}/rgb.png", "room{}/depth.png", ("", "2")),
        ("frame-{}.color.png", "frame-{}.depth.png", ("000000", "000001")),
        ("r-{}-1.ppm", "d-{}-2.pgm", times),
        ("lowres_wide/4242_{}.png", "lowres_depth/4242_{}.png", ("100.123", "100.223")),
    )
    return ["\n".join(form.format(one) for one in ones for form in pair).encode() for *pair, ones in forms]

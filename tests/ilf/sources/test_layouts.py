"""Layouts as data: every published one on files named and encoded as published, given ones, and what does not fit."""

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import DepthWarning, FormatError, InputError, ParameterError
from ilf.io.encodings import encoding_of
from ilf.sources.layout import layouts_from_file
from ilf.sources.layouts import all_layouts, built_in_layouts
from tests.ilf.image_files import write_file, write_rgbd

H, W = 48, 64
METRES = (1.5 + 0.007 * np.arange(W)[None] + 0.02 * np.arange(H)[:, None]).astype(np.float32)
METRES[10:20, 30:40] = 0
TRUTH = np.where(METRES == 0, 2.25, METRES).astype(np.float32)
NUMBERS = FX, FY, CX, CY = 60.0, 61.5, 30.25, 24.75
K = np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])
WIDE = np.array([[120.0, 0, 63.5], [0, 120.0, 47.5], [0, 0, 1]])
"""The camera of colour of twice the size of depth."""
POSE = np.array([[0, 0, 1, 1], [-1, 0, 0, 2], [0, -1, 0, 3], [0, 0, 0, 1]], float)
"""From the camera, y down, to the world."""
POSES = [POSE, POSE + np.eye(4, k=3)]
"""The second is one metre further in x."""
Y_UP = [pose @ np.diag([1.0, -1, -1, 1]) for pose in POSES]


@pytest.fixture(autouse=True)
def no_own_layouts(tmp_path, monkeypatch):
    monkeypatch.setenv("ILF_LAYOUTS", str(tmp_path / "own-layouts"))
    return tmp_path / "own-layouts"


def _grey(height: int = H, width: int = W) -> np.ndarray:
    return np.full((height, width, 3), 90, np.uint8)


def _line(values: np.ndarray) -> str:
    return " ".join(map(str, values.ravel()))


def _square(matrix: np.ndarray) -> np.ndarray:
    return np.block([[matrix, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


def _longer(fx: float, fy: float, cx: float = 31.5, cy: float = 23.5) -> np.ndarray:
    """Lengths of rays to the plane at 1 m."""
    x, y = (np.arange(W) - cx) / fx, (np.arange(H) - cy) / fy
    return np.sqrt(1 + x**2 + y[:, None] ** 2).astype(np.float32)


def _transforms(**depth: str) -> dict[str, Any]:
    frames = [
        {"file_path": f"./images/{number:05}.jpg", "transform_matrix": pose.tolist()}
        | {key: name.format(n=number) for key, name in depth.items()}
        for number, pose in enumerate(Y_UP)
    ]
    camera = {"camera_model": "OPENCV", "fl_x": FX, "fl_y": FY, "cx": CX + 0.5, "cy": CY + 0.5, "w": W, "h": H}
    return camera | {"frames": frames}


def _info() -> str:
    kinds = "".join(f"m_calibration{kind}Intrinsic = {_line(_square(K))} \n" for kind in ("Color", "Depth"))
    return f"m_versionNumber = 4\nm_colorWidth = {W}\nm_depthShift = 1000\n{kinds}m_frames.size = 2\n"


def _polycam(pose: np.ndarray) -> dict[str, float]:
    stated = LENS | {"width": W, "height": H, "blur_score": 80.1}
    return stated | {f"t_{row}{column}": pose[row, column] for row in range(3) for column in range(4)}


PANORAMA = "0b02e18654324edd8d74c078b66bfb20"
DREDS = np.pad(METRES[:45], ((0, 0), (0, 16)), constant_values=1.5)
SKY = np.pad(np.where(METRES > 0, METRES, 655.35), ((0, 0), (0, 95)), constant_values=30)
SQUARE = np.vstack((METRES, METRES[:16]))
HO3D = np.rint(METRES / 0.00012498664727900177).astype(np.uint16)
ISAAC = 20 / 20.955 * W
LENS = {"fx": FX, "fy": FY, "cx": CX, "cy": CY}
SIZE = {"w": W, "h": H}
# what files contain; of a list, each frame has its own
CONTENTS = {
    "grey": _grey(),
    "grey-80x45": _grey(45, 80),
    "grey-80x64": _grey(64, 80),
    "grey-128x96": _grey(96, 128),
    "grey-wide": _grey(*SKY.shape),
    "grey-square": _grey(*SQUARE.shape),
    "depth": METRES,
    "truth": TRUTH,
    "mask": (METRES > 0).astype(np.uint16),
    "K": K,
    "K-of-colour": _square(np.array([[121.5, 0, 60.25], [0, 121.5, 47.75], [0, 0, 1]])),
    "K-of-four-rows": _square(K),
    "K-line": _line(K),
    "K-json": SIZE | {"fps": 30, "K": K.T.ravel().tolist()},
    "K-npz": {"intrinsics": K},
    "poses": POSES,
    "poses-of-three-rows": [pose[:3] for pose in POSES],
    "poses-in-lines": np.array([pose.ravel() for pose in POSES]),
    "kitti-calibration": f"calib_time: 09-Jan-2012 13:57:47\nP_rect_00: {'1 ' * 12}\n"
    f"P_rect_02: {_line(np.c_[K, [44.0, 0.2, 0.003]])}\n",
    "matterport-intrinsics": f"{W} {H} {FX} {FY} {CX} {CY} 0.04 -0.16 0.0006 -0.0005 0.0",
    "padded": np.pad(METRES, ((0, 16), (0, 16))),
    "matterport-conf": "dataset matterport\nn_images 2\ndepth_directory undistorted_depth_images\n"
    "color_directory undistorted_color_images\nintrinsics_matrix 1280 0 620  0 1264 500.5  0 0 1\n"
    + "\n".join(f"scan {PANORAMA}_d0_{n}.png {PANORAMA}_i0_{n}.jpg {_line(Y_UP[n])}" for n in range(2)),
    "hypersim-rays": (METRES * _longer(886.81 * W / 1024, 886.81 * W / 1024)).astype(np.float16),
    "dreds": DREDS,
    "dreds-truth": np.where(DREDS == 0, 2.25, DREDS),
    "diode": TRUTH[..., None],
    "diode-mask": (METRES > 0).astype(np.float64),
    "cleargrasp-camera": f"# D435\nxres: {W}\nyres: {H}\nfx: {FX}\nfy: {FY}\ncx: {CX}\ncy: {CY}\n",
    "isaac": np.where(METRES > 0, METRES, np.float32(np.inf)),
    "isaac-rays": np.where(METRES > 0, METRES * _longer(ISAAC, ISAAC), np.float32(np.inf)),
    "isaac-camera": {"cameraAperture": [20.955, 15.7], "cameraFocalLength": 20.0, "renderProductResolution": [W, H]},
    "polycam-camera": [_polycam(pose) for pose in Y_UP],
    "confidence": np.full((H, W), 255, np.uint16),
    "transforms": _transforms(depth_file_path="depth/{n:05}.png"),
    "transforms-alone": _transforms(),
    "replica-camera": {"camera": LENS | SIZE | {"scale": 6553.5}},
    "open3d-camera": {"width": W, "height": H, "intrinsic_matrix": K.T.ravel().tolist()},
    "open3d-log": "".join(f"{n} {n} {n + 1}\n" + "".join(f"{_line(row)}\n" for row in POSES[n]) for n in range(2)),
    "info": _info(),
    "other": "of another program",
    "sky": SKY,
    "bytes": SQUARE.astype("<f4").view(np.uint8).reshape(*SQUARE.shape, 4),
    "scenenet-rays": METRES
    * _longer(277.12813 * W / 320, 289.70563 * W / 320, 160.5 * W / 320 - 0.5, 120.5 * W / 320 - 0.5),
    "interiornet-rays": METRES * _longer(60, 60, 31.55, 23.55),
    "kubric-rays": METRES * _longer(W * 35 / 32, W * 35 / 32),
    "kubric-camera": {
        "camera": {"focal_length": 35.0, "sensor_width": 32.0, "field_of_view": 0.857, "R": np.eye(4).tolist()}
        | {"K": [[35 / 32, 0, -0.5], [0, -35 / 24, -0.5], [0, 0, -1]]},
        "metadata": {"width": W, "height": H},
    },
    "taskonomy": np.where(METRES > 0, 512 * METRES, 65535),
    "taskonomy-pose": {"camera_k_matrix": K.tolist(), "camera_rt_matrix": POSE[:3].tolist()},
    "bop-camera": {"cam_K": K.ravel().tolist(), "depth_scale": 0.1},
    "ho3d": np.dstack((0 * HO3D, HO3D >> 8, HO3D & 255)).astype(np.uint8),
    "halves": METRES.astype(np.float16).view(np.uint16),
    "scanner-camera": {"intrinsics": K.ravel().tolist(), "frame_index": 0},
    "scannetpp-poses": {
        f"frame_{10 * n:06}": {"pose": np.eye(4).tolist(), "aligned_pose": pose.tolist(), "intrinsic": K.tolist()}
        for n, pose in enumerate(POSES)
    },
}


def _write(root: Path, *files: str, numbers: Iterable[object] = (0, 1), **contents: Any) -> None:
    """Write files of frames: "name: content" or "name: content*units"; {n} in a name is the number of the frame."""
    for line in files:
        name, _, stated = line.partition(": ")
        content, _, units = stated.partition("*")
        values = (CONTENTS | contents)[content]
        for number, own in zip(numbers, values if isinstance(values, list) else [values] * 2, strict=True):
            write_file(root / name.format(n=number), float(units) * own if units else own)


def _published() -> dict[str, tuple[list[str], tuple[float, ...], list[object], str]]:
    """Of each data set in the table: files, fx, fy, cx and cy, the frames' numbers or times, and what else it gives."""
    data_sets = {}
    for line in Path(__file__).with_name("published_layouts.txt").read_text().splitlines():
        if line.startswith("["):
            name, camera, numbers, gives = line.strip("[]").split("|")
            counted = [int(number) if number.isdigit() else number for number in numbers.split()]
            files: list[str] = []
            known = NUMBERS if "K" in camera else tuple(map(float, camera.split()))
            data_sets[name.strip()] = files, known, counted, gives
        elif not line.startswith("#"):
            files.append(line)
    return data_sets


PUBLISHED = _published()


def _write_published(root: Path, name: str) -> None:
    files, _, numbers, _ = PUBLISHED[name]
    _write(root, *files, numbers=numbers)


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_layouts_are_read_right_at_once(tmp_path, name):
    _, camera, _, gives = PUBLISHED[name]
    _write_published(tmp_path / "data", name)
    source = ilf.open_source(tmp_path / "data")
    assert (source.layout.partition(" ")[0], len(source)) == (name.partition(",")[0], 2), source.notes
    frame = source[1]
    height, width = min(H, frame.shape[0]), min(W, frame.shape[1])
    wanted = np.where(METRES == 0, np.nan, METRES)[:height, :width]
    assert np.allclose(frame.depth[:height, :width], wanted, atol=5e-3, equal_nan=True)
    assert (frame.intrinsics.numbers if frame.intrinsics else ()) == pytest.approx(camera, rel=1e-4)
    assert frame.plausibility_warnings == ()
    assert (frame.ground_truth is not None) == ("truth" in gives)
    if "truth" in gives:
        assert frame.ground_truth[15, 35] == pytest.approx(2.25, abs=2e-3)
    if "poses" in gives:
        assert np.allclose(source.pose(source.keys[1]), POSES[1])
        assert np.allclose(frame.pose, POSES[1])
    else:
        assert frame.pose is None
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth if frame.invalid_mask is None else frame.measured, equal_nan=True)


@pytest.mark.parametrize("below", ["", "scene", "scene/seq-01"])
def test_frames_that_are_named_as_in_seven_scenes_have_their_own_camera(tmp_path, below):
    start = "seq-01/frame-{n:06}"
    files = f"{start}.color.png: grey", f"{start}.depth.png: depth*1000", f"{start}.pose.txt: poses"
    _write(tmp_path / "scene", *files, "camera-intrinsics.txt: K")
    source = ilf.open_source(tmp_path / below)
    assert (len(source), source[0].intrinsics.fx) == (2, 60.0)
    (tmp_path / "scene/camera-intrinsics.txt").unlink()
    assert ilf.open_source(tmp_path / below)[0].intrinsics.fx == pytest.approx(585 * W / 640)


@pytest.mark.parametrize(
    ("name", "scale", "units"),
    [("intrinsics.json", 0.0001, 10000), ("intrinsic.json", 4000.0, 4000), ("camera.json", None, 1000)],
)
def test_depth_has_the_scale_that_its_camera_states(tmp_path, name, scale, units):
    """librealsense states metres per unit, Open3D units per metre."""
    stated = {} if scale is None else {"depth_scale": scale}
    camera = {"fx": 60, "fy": 60, "ppx": 31.5, "ppy": 23.5} | stated
    files = "color/{n:06}.png: grey", f"depth/{{n:06}}.png: depth*{units}", f"{name}: camera"
    _write(tmp_path, *files, camera=camera)
    frame = ilf.open_source(tmp_path)[0]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-3, equal_nan=True)
    assert frame.intrinsics.fx == 60


@pytest.mark.parametrize("file", ["camK.npy", "metadata"])
def test_the_camera_beside_folders_of_colour_and_depth_is_read(tmp_path, file):
    """GraspNet and WildRGB-D."""
    stated = "K" if file == "camK.npy" else "K-json"
    _write(tmp_path, "rgb/{n:04}.png: grey", "depth/{n:04}.png: depth*1000", f"{file}: {stated}")
    assert ilf.open_source(tmp_path)[0].intrinsics.numbers == NUMBERS


def test_depth_of_instant_ngp_has_its_own_names_and_scale(tmp_path):
    stated = _transforms(depth_path="deep/{n:04}_z.png") | {"integer_depth_scale": 1 / 2000}
    files = "images/{n:05}.jpg: grey", "deep/{n:04}_z.png: depth*2000", "transforms.json: stated"
    _write(tmp_path, *files, stated=stated)
    frame = ilf.open_source(tmp_path)[1]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-3, equal_nan=True)


def test_depth_of_a_phone_is_registered_to_its_larger_colour(tmp_path):
    _write_published(tmp_path, "polycam")
    for number in range(2):
        write_file(tmp_path / f"keyframes/corrected_images/{144200852560 + number}.jpg", _grey(2 * H, 2 * W))
        path = tmp_path / f"keyframes/corrected_cameras/{144200852560 + number}.json"
        wide = {"fx": 120.0, "fy": 120.0, "cx": 63.5, "cy": 47.5, "width": 2 * W, "height": 2 * H}
        path.write_text(json.dumps(json.loads(path.read_text()) | wide))
    frame = ilf.open_source(tmp_path)[0]
    assert (frame.shape, frame.intrinsics.fx) == ((2 * H, 2 * W), 120.0)
    assert np.nanmedian(frame.depth) == pytest.approx(np.median(METRES[METRES > 0]), abs=0.02)
    with pytest.raises(InputError, match=r"confidence map must have the same pixels.* \(--view depth\)"):
        ilf.open_source(tmp_path, min_confidence=255)[0]
    own = ilf.open_source(tmp_path / "keyframes", min_confidence=255, view="depth")  # a folder in the data set
    assert own.layout.startswith("polycam ")
    assert (own[0].shape, own[0].intrinsics.fx) == ((H, W), 60.0)
    assert np.allclose(own.pose(own.keys[1]), POSES[1])


@pytest.mark.parametrize("name", ["3d-scanner-app", "record3d-exr", "nerfstudio"])
def test_one_camera_is_that_of_colour_and_of_its_smaller_depth(tmp_path, name):
    """Phones give depth of the view of colour in fewer pixels, and programs state the camera of colour alone."""
    _write_published(tmp_path, name)
    for path in [*tmp_path.rglob("*.jpg")]:
        write_file(path, _grey(2 * H, 2 * W))
    for path in tmp_path.rglob("*.json"):
        stated = json.loads(path.read_text())
        wide = {"fl_x": 120.0, "fl_y": 120.0, "cx": 64.0, "cy": 48.0, "w": 2 * W, "h": 2 * H}
        wide = {"K": WIDE.T.ravel().tolist(), "w": 2 * W, "h": 2 * H} if "K" in stated else wide
        path.write_text(json.dumps(stated | ({"intrinsics": WIDE.tolist()} if "intrinsics" in stated else wide)))
    source = ilf.open_source(tmp_path)
    frame = source[0]
    assert (frame.shape, frame.intrinsics.numbers) == ((2 * H, 2 * W), (120.0, 120.0, 63.5, 47.5))
    assert np.nanmedian(frame.depth) == pytest.approx(np.median(METRES[METRES > 0]), abs=0.02)
    assert np.array_equal(ilf.load_frame(**frame.sources).depth, frame.depth, equal_nan=True)
    given = ilf.open_source(tmp_path, intrinsics=(130.0, 130.0, 63.5, 47.5))[0]
    assert given.intrinsics.fx == 130


def test_shares_of_a_kilometre_have_coarse_steps(tmp_path):
    files = "ani/rgbs/rgb_{n:05}.jpg: grey", "ani/depths/depth_{n:05}.png: depth*65.535"
    _write(tmp_path, *files, "ani/anno.npz: K-npz")
    frame = ilf.open_source(tmp_path)[1]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=0.008, equal_nan=True)


def test_a_file_named_distance_to_camera_is_along_rays_if_the_camera_is_known(tmp_path):
    _write_published(tmp_path, "isaac-sim-rays")
    files = tmp_path / "rgb_0001.png", tmp_path / "distance_to_camera_0001.npy"
    frame = ilf.load_frame(*files, intrinsics=str(tmp_path / "camera_params_0001.json"))
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-5, equal_nan=True)
    assert frame.inputs.encoding.startswith("ray:1.0,")
    with pytest.warns(DepthWarning, match="distances along the rays"):
        ilf.load_frame(*files)


def test_frames_of_scannet_are_registered_by_the_two_cameras(tmp_path):
    files = "color/{n}.jpg: grey-128x96", "depth/{n}.png: depth*1000", "pose/{n}.txt: poses"
    cameras = "intrinsic/intrinsic_color.txt: K-of-colour", "intrinsic/intrinsic_depth.txt: K-of-four-rows"
    _write(tmp_path / "data/scans/scene0000_00", *files, *cameras)
    source = ilf.open_source(tmp_path / "data/scans/scene0000_00")
    assert (source.keys, source.is_registered) == (("color/0", "color/1"), False)
    frame = source[1]
    assert frame.shape == (96, 128)
    assert frame.intrinsics.fx == pytest.approx(121.5)
    # the pixel of colour sees the same direction as a pixel of depth
    column, row = (
        round((value - centre) / 60 * 121.5 + middle) for value, centre, middle in ((10, CX, 60.25), (30, CY, 47.75))
    )
    assert frame.depth[row, column] == pytest.approx(METRES[30, 10], abs=0.02)
    assert np.allclose(frame.pose, POSES[1])
    pair = source.read_pair("color/1")
    assert (pair.rgb.shape[:2], pair.depth.shape, pair.depth_camera.fx) == ((96, 128), (H, W), 60.0)
    calibration = source.calibration("color/1")
    assert (calibration.colour.fx, calibration.depth.fx) == (121.5, 60.0)
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    every = ilf.open_source(tmp_path / "data")
    assert every.keys == ("scans/scene0000_00/color/0", "scans/scene0000_00/color/1")


def test_two_files_of_different_sizes_are_registered_or_refused_with_the_cure(tmp_path, cli):
    files = [str(path) for path in write_rgbd(tmp_path, 1000 * METRES, colour=(96, 128))]
    assert "--intrinsics and --depth-intrinsics" in cli("complete", *files, "--out", tmp_path / "out", status=1).err
    with pytest.raises(InputError, match="also give the intrinsics of colour"):
        ilf.load_frame(*files, depth_intrinsics=(60, 60, 31.5, 23.5))
    cameras = ["--intrinsics", "120,120,63.5,47.5", "--depth-intrinsics", "60,60,31.5,23.5"]
    assert re.search("registered: +on reading", cli("info", *files, *cameras).out)
    how = ["--out", str(tmp_path / "out"), "--max-iterations", "5", "--no-cloud", "--quiet"]
    assert main(["complete", *files, *cameras, *how]) == 0
    again = ["complete", "--replay", str(tmp_path / "out/run.json"), "--out", str(tmp_path / "again"), "--quiet"]
    assert main(again) == 0
    assert (tmp_path / "again/depth.npy").read_bytes() == (tmp_path / "out/depth.npy").read_bytes()


@pytest.mark.parametrize("number", range(4))
@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_cameras_of_one_size_that_differ_are_doubted_whichever_is_larger(tmp_path, factor, number):
    files = write_rgbd(tmp_path, 1000 * METRES)
    other = [value * (factor if at == number else 1) for at, value in enumerate(NUMBERS)]
    with pytest.warns(DepthWarning, match="their cameras differ"):
        ilf.load_frame(*files, intrinsics=NUMBERS, depth_intrinsics=other)


def test_replica_is_named_and_found_one_folder_up(tmp_path, cli):
    _write_published(tmp_path, "replica")
    told = cli("info", tmp_path / "room0").out
    assert "layout:        replica (Replica, as rendered for NICE-SLAM)" in told
    assert "depth camera:  fx 60" in told, "cam_params.json lies above"
    listed = json.loads(cli("info", "--layouts", "--json").out)["layouts"]
    assert [layout["name"] for layout in listed] == [layout.name for layout in built_in_layouts()]


def test_other_layouts_that_fit_are_named(tmp_path):
    _write_published(tmp_path, "transcg")
    source = ilf.open_source(tmp_path / "scene1")
    assert "transcg-l515" in source.notes[-1]
    other = ilf.open_source(tmp_path / "scene1", layout="transcg-l515")
    assert other.keys == ("0/rgb2", "1/rgb2")
    assert other[0].inputs.depth_units == 4000
    assert other[0].ground_truth[15, 35] == pytest.approx(2.25, abs=1e-3)


def test_depth_beside_the_images_of_a_transforms_json(tmp_path):
    _write_published(tmp_path, "nerfstudio, depth beside")
    source = ilf.open_source(tmp_path)
    assert source.is_registered  # one camera is stated for both
    assert source[1].intrinsics.cx == CX, "its pixels are counted from a corner"
    data = json.loads((tmp_path / "transforms.json").read_text()) | {"depth_unit_scale_factor": 0.0005}
    (tmp_path / "transforms.json").write_text(json.dumps(data))
    assert ilf.open_source(tmp_path)[1].inputs.depth_units == 2000
    assert set(ilf.open_source(tmp_path).ref("images/00001").options.intrinsics) == {
        *("fx", "fy", "cx", "cy", "width", "height", "lens", "name")
    }
    (tmp_path / "transforms.json").write_text('{"frames": [{"file_path": 3}]}')
    with pytest.raises(FormatError, match=r"transforms\.json contains no camera poses"):
        ilf.open_source(tmp_path)


def test_images_of_one_name_in_two_folders_keep_their_own_depth_and_pose(tmp_path):
    frames = []
    for camera, pose in zip("ab", Y_UP, strict=True):
        write_file(tmp_path / f"{camera}/0001.jpg", _grey())
        write_file(tmp_path / f"depth_{camera}/0001.png", 1000 * METRES * (1 if camera == "a" else 2))
        names = {"file_path": f"{camera}/0001.jpg", "depth_file_path": f"depth_{camera}/0001.png"}
        frames.append(names | {"transform_matrix": pose.tolist(), "fl_x": 60.0, "cx": 32, "cy": 24})
    write_file(tmp_path / "transforms.json", {"frames": frames})
    source = ilf.open_source(tmp_path)
    assert source.keys == ("a/0001", "b/0001")
    assert [round(float(frame.depth[0, 0]), 3) for frame in source] == [1.5, 3.0]
    assert np.allclose(source[1].pose, POSES[1])
    assert source[1].intrinsics.fy == 60


def test_images_of_a_layout_without_depth_are_told(tmp_path):
    _write_published(tmp_path, "kitti")
    notes = ("2 colour images left out: there is no depth image of that name.",)
    assert ilf.open_source(tmp_path).notes == notes


def test_a_layout_is_given_as_text(tmp_path):
    _write_published(tmp_path, "void")
    text = "rgb={}/image/*.png depth={}/ground_truth/*.png units=256 K=K.txt pose=absolute_pose/*.txt"
    source = ilf.open_source(tmp_path / "void_1500", layout=text)
    assert source.keys[0] == "data/classroom0/image/1552625028.2387"
    assert source.timestamps == (1552625028.2387, 1552625028.3387)
    frame = source[0]
    assert not np.isnan(frame.depth).any()
    assert frame.intrinsics.fx == 60
    assert np.allclose(frame.pose, POSE)
    assert source.notes == ()
    told = ilf.open_source(tmp_path / "void_1500", layout=f"{text} truth=gt/*.png").notes
    assert told == ("There is no file truth=gt/*.png: frames are read without.",)
    mine = ilf.open_source(tmp_path / "void_1500", layout=text, depth_units=512, intrinsics="50,50,32,24")
    assert (mine[0].inputs.depth_units, mine[0].intrinsics.fx) == (512, 50), "what the user states precedes the layout"


def test_poses_from_the_world_and_with_y_up_are_turned(tmp_path):
    seen_from = [np.linalg.inv(pose) for pose in Y_UP]
    _write(tmp_path, "rgb/{n}.png: grey", "depth/{n}.png: depth*1000", "w2c/{n}.txt: seen_from", seen_from=seen_from)
    text = "rgb=rgb/*.png depth=depth/*.png pose=w2c/*.txt pose_maps=world-to-camera pose_axes=y-up"
    assert np.allclose(ilf.open_source(tmp_path, layout=text)[1].pose, POSES[1])


def test_own_layouts_precede_the_table(tmp_path, no_own_layouts):
    _write_published(tmp_path, "void")
    no_own_layouts.mkdir()
    own = no_own_layouts / "lab.toml"
    own.write_text(
        '[lab]\ntitle = "Our lab"\nrgb = "{}/image/*.png"\ndepth = "{}/ground_truth/*.png"\nunits = 256\n'
        '[void]\nrgb = "{}/image/*.jpg"\ndepth = "{}/sparse_depth/*.png"\n'
    )
    source = ilf.open_source(tmp_path / "void_1500")
    assert source.layout == "lab (Our lab)"
    assert [layout.name for layout in all_layouts()].count("void") == 1
    alone = tmp_path / "own.toml"
    alone.write_text('rgb = "image/*.png"\ndepth = "sparse_depth/*.png"\nunits = 256\n')
    assert ilf.open_source(tmp_path / "void_1500/data/classroom0", layout=alone).layout == "own"
    own.write_text('[lab]\nrgb = "a/*.png"\n')
    with pytest.raises(FormatError, match=r"lab\.toml: The layout 'lab' has no 'depth'"):
        ilf.open_source(tmp_path / "void_1500")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rgb=a.png", "has no 'depth'"),
        ("rgb=a.png depth=b.png", "no placeholder in common"),
        ("rgb=*.png depth={x}.png", "no placeholder in common"),
        ("rgb=*.png depth=d/*.png K={camera}.txt", r"has \{camera\}"),
        ("rgb=*.png depth=d/*.png colour=1", "unknown field"),
        ("rgb=*.png depth=d/*.png units=mm", "units"),
        ("rgb=*.png depth=d/*.png units=0", "'units' in the layout"),
        ("rgb=*.png depth=d/*.png units=5 encoding=mm", "only one of them"),
        ("rgb=*.png depth=d/*.png distance=ray", "needs K"),
        ("rgb=*.png depth=d/*.png pose_axes=left", "pose_axes"),
        ("rgb=*.png rgb=d/*.png", "given twice"),
        ("rgb='*.png depth=d/*.png", "quotation"),
        ("rgb={*.png,x/*_*.png} depth=*.png", "same placeholders"),
        ("rgb=*_*_*_*_*.png depth=d/*.png", "placeholders in a name"),
        (f"rgb={'{a,b}' * 7}/*.png depth=d/*.png", "64 alternatives"),
        ("rgb=/*.png depth=d/*.png", "path in the data set"),
        ("rgb=a/{}/*.png depth=d/*.png", "path in the data set"),
        ("nothing", "There is no layout 'nothing'"),
    ],
)
def test_layouts_that_are_not_valid_say_why(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        ilf.open_source(tmp_path, layout=text)


def test_what_does_not_fit_names_the_layout_and_the_nearest(tmp_path):
    _write_published(tmp_path, "void")
    scene = tmp_path / "void_1500/data/classroom0"
    with pytest.raises(InputError, match=r"scannet \(.*color.* matches 0 files.*It fits the layout void"):
        ilf.open_source(scene, layout="scannet")
    (scene / "sparse_depth").rename(scene / "sparse")
    with pytest.raises(
        InputError, match=r"The nearest layout is void \(VOID\): it finds .*K\.txt.*, but lacks .*sparse_depth"
    ):
        ilf.open_source(scene)
    for text in ("rgb = ", "rgb = " + "9" * 5000):
        with pytest.raises(FormatError, match="not valid TOML"):
            layouts_from_file(write_file(tmp_path / "a.toml", text))
    with pytest.raises(FormatError, match="more than 64 KiB"):  # whose name takes a minute
        layouts_from_file(write_file(tmp_path / "a.toml", f"{'a.' * 200_000}a = 1"))
    with pytest.raises(FormatError, match=r"must contain a table"):
        layouts_from_file(write_file(tmp_path / "a.toml", "a = 1"))
    (scene / "sparse").rename(scene / "sparse_depth")
    (scene / "K.txt").write_text("1 2 3")
    with pytest.raises(FormatError, match=r"K\.txt must contain a camera matrix"):
        ilf.open_source(scene)


def test_distance_along_the_ray_becomes_depth():
    encoding = encoding_of("ray:1000,60,60,31.5,23.5")
    values = np.rint(1000 * METRES * _longer(60, 60)).astype(np.uint16)
    assert np.allclose(np.nan_to_num(encoding.metres(values)), METRES, atol=1e-3)
    assert encoding_of(encoding.name) == encoding
    for wrong in ("ray:1000,60", "ray:0,1,1,1,1", "ray:1,0,1,1,1", "ray:1,1,1,1,1,inf,5", "ray:x"):
        with pytest.raises(ParameterError):
            encoding_of(wrong)
    with pytest.raises(FormatError, match="aspect ratio"):
        encoding_of("ray:1,60,60,31.5,23.5,64,64").metres(values)

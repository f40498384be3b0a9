"""The camera that a frame gets: implausible ones are doubted, lenses that are no pinhole are left out and named."""

import json

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.data.camera import CAMERA_DOUBT, Camera, camera_doubt
from ilf.errors import DepthWarning, InputError
from ilf.io.images import encode_image
from tests.ilf.image_files import write_rgbd

SHAPE = H, W = 120, 160
COLOUR = np.zeros((H, W, 3), np.uint8)
MILLIMETRES = np.linspace(1000, 3000, H * W).astype(np.uint16).reshape(SHAPE)
TRUE = {
    "D435, wide": ((425.0, 425.0, 421.3, 240.9), (848, 480)),
    "Azure Kinect, 120 degrees": ((504.2, 504.1, 512.3, 513.8), (1024, 1024)),
    "Azure Kinect, narrow": ((503.9, 504.0, 332.1, 325.9), (640, 576)),
    "iPhone, upright": ((1339.1, 1339.1, 718.4, 965.2), (1440, 1920)),
    "NYU, cropped": ((518.86, 519.47, 284.58, 208.74), (561, 427)),
    "KITTI": ((721.5, 721.5, 609.6, 172.9), (1242, 375)),
    "KITTI, cropped": ((721.5, 721.5, 596.1, 149.9), (1216, 352)),
    "Azure Kinect, low principal point": ((503.9, 504.0, 322.1, 339.9), (640, 576)),
    "iPhone, telephoto": ((4300.0, 4300.0, 960.0, 720.0), (1920, 1440)),
    "telephoto of 12 degrees": ((3045.0, 3045.0, 319.5, 239.5), (640, 480)),
    "T-LESS, cropped": ((1076.0, 1073.0, 188.2, 254.1), (400, 400)),
    "sensor of 8 x 8 zones": ((9.66, 9.66, 3.5, 3.5), (8, 8)),
}
WRONG = {
    "normalised": ((0.8203, 1.09375, 0.5, 0.5), r"0\.8203 \* 160 = 131\.2 px"),
    "960 x 720": ((787.5, 787.5, 477.0, 357.0), r"960 x 720.*131\.2 px"),
    "240 x 180": ((196.9, 196.9, 119.5, 89.5), r"outside the middle|centre of"),
    "200 x 150": ((164.1, 164.1, 99.5, 74.5), "centre of|outside the middle"),
    "106 x 80": ((87.5, 87.5, 52.8, 39.5), r"centre of 107 x 80"),
    "millimetres": ((4.25, 4.25, 79.5, 59.5), "174 degrees"),
    "turned": ((131.25, 131.25, 59.5, 79.5), r"120 x 160"),
    "off the image": ((131.25, 131.25, 700.0, 10.0), "middle half"),
    "narrow": ((2000.0, 2000.0, 79.5, 59.5), "4.58 degrees"),
    "wide": ((15.0, 15.0, 79.5, 59.5), "159 degrees"),
}


@pytest.fixture
def files(tmp_path):
    return [str(path) for path in write_rgbd(tmp_path, MILLIMETRES)]


@pytest.mark.parametrize("name", TRUE)
def test_true_cameras_are_not_doubted(name):
    numbers, (width, height) = TRUE[name]
    assert camera_doubt(Camera(*numbers), (height, width)) == ""


@pytest.mark.parametrize("name", WRONG)
def test_an_implausible_camera_is_doubted_once(files, name, cli):
    numbers, told = WRONG[name]
    with pytest.warns(DepthWarning, match=told) as caught:
        frame = ilf.load_frame(*files, intrinsics=numbers)
    assert len(caught) == len(frame.plausibility_warnings) == len(frame.notes) == 1
    assert frame.notes[0] in cli("info", *files, "--intrinsics", ",".join(map(str, numbers))).out
    assert main(["info", *files, "--strict", "--intrinsics", ",".join(map(str, numbers))]) == 1
    with pytest.warns(DepthWarning, match=told):
        made = ilf.RGBDFrame(COLOUR, MILLIMETRES / 1000, numbers)
    assert made.notes == frame.notes


def test_relative_numbers_are_not_scaled_to_the_image(files, tmp_path):
    stated = {"fx": 0.8203, "fy": 1.09375, "cx": 0.5, "cy": 0.5, "width": 640, "height": 480}
    (tmp_path / "camera.json").write_text(json.dumps(stated))
    with pytest.warns(DepthWarning, match=r"131\.2 px"):
        ilf.load_frame(*files, intrinsics=str(tmp_path / "camera.json"))


@pytest.mark.parametrize("size", ["1e999,120", "160.5,120", "-160,120"])
def test_an_impossible_size_behind_the_numbers_is_told(files, size):
    with pytest.raises(InputError, match="width and a height in pixels"):
        ilf.load_frame(*files, intrinsics=f"131,131,79.5,59.5,{size}")


def test_two_cameras_may_be_mappings_with_matrices(files, tmp_path):
    (tmp_path / "depth.png").write_bytes(encode_image(".png", MILLIMETRES[::2, ::2]))
    colour, depth = (
        np.array([[f, 0, cx], [0, f, cy], [0, 0, 1]]) for f, cx, cy in ((131, 79.5, 59.5), (65, 39.5, 29.5))
    )
    frame = ilf.load_frame(*files, intrinsics={"K": colour}, depth_intrinsics={"K": depth})
    assert frame.intrinsics.fx == 131


def test_the_camera_of_depth_of_another_size_is_doubted(files, tmp_path):
    (tmp_path / "depth.png").write_bytes(encode_image(".png", MILLIMETRES[::2, ::2]))
    with pytest.warns(DepthWarning, match=f"Depth camera: {CAMERA_DOUBT}.*160 x 120"):
        frame = ilf.load_frame(
            *files, intrinsics=(131.25, 131.25, 79.5, 59.5), depth_intrinsics=(130.0, 130.0, 79.5, 59.5)
        )
    assert "Depth camera" in frame.notes[0]


@pytest.mark.parametrize("is_stated", [True, False])
def test_the_place_of_the_depth_camera_that_is_not_used_is_said(files, tmp_path, is_stated):
    """DepthAI states that the cameras are 75 mm apart, in centimetres."""
    (tmp_path / "depth.png").write_bytes(encode_image(".png", MILLIMETRES[::2, ::2]))
    cameras = []
    for socket, size in ((0, (W, H)), (2, (W // 2, H // 2))):
        matrix = [[0.82 * size[0], 0, size[0] / 2], [0, 0.82 * size[0], size[1] / 2], [0, 0, 1]]
        camera = {"intrinsicMatrix": matrix, "width": size[0], "height": size[1]}
        place = {"extrinsics": {"translation": {"x": -7.5, "y": 0.0, "z": 0.0}, "toCameraSocket": 0}}
        cameras.append([socket, camera | (place if is_stated else {})])
    path = tmp_path / "oak.json"
    path.write_text(json.dumps({"cameraData": cameras}))
    frame = ilf.load_frame(*files, intrinsics=f"{path}#CAM_A", depth_intrinsics=f"{path}#CAM_C", warn=False)
    assert any("as if they were in one place" in note for note in frame.notes) == is_stated


def _transforms(folder, facts, separator="/", suffix=".png"):
    for name in ("f0", "f1"):
        for kind, image in (("images", COLOUR), ("depth", MILLIMETRES)):
            (folder / kind).mkdir(exist_ok=True)
            (folder / kind / f"{name}.png").write_bytes(encode_image(".png", image))
    frames = [
        {"file_path": f"images{separator}{name}{suffix}", "depth_file_path": f"depth{separator}{name}.png",
         "transform_matrix": np.eye(4).tolist()}
        for name in ("f0", "f1")
    ]  # fmt: skip
    frames[1] |= facts.pop("second", {})
    (folder / "transforms.json").write_text(json.dumps({**facts, "frames": frames}))


PINHOLE = {"fl_x": 131.25, "fl_y": 131.25, "cx": 80.0, "cy": 60.0, "w": W, "h": H}


@pytest.mark.parametrize(
    ("lens", "told"),
    [("OPENCV_FISHEYE", "is a fisheye"), ("EQUIRECTANGULAR", "'EQUIRECTANGULAR'"), ("FISHEYE624", "'FISHEYE624'")],
)
def test_frames_of_other_lenses_have_no_camera_and_say_why(tmp_path, cli, lens, told):
    _transforms(tmp_path, PINHOLE | {"camera_model": lens, "k1": 0.05})
    with pytest.warns(DepthWarning, match=told):
        frame = ilf.open_source(tmp_path)[0]
    assert frame.intrinsics is None
    assert told in frame.notes[0]
    assert told in cli("info", tmp_path).out
    with pytest.raises(InputError, match="ntrinsics"):
        ilf.point_cloud(frame.depth, frame.rgb, frame.intrinsics)


def test_an_impossible_camera_is_refused_with_the_name_of_its_file(tmp_path):
    _transforms(tmp_path, PINHOLE | {"fl_x": -131.25})
    with pytest.raises(InputError, match=r"transforms\.json: Focal lengths must be positive"):
        ilf.open_source(tmp_path)[0]


def test_distortion_of_transforms_is_noted_as_that_of_recordings(tmp_path):
    _transforms(tmp_path, PINHOLE | {"camera_model": "OPENCV", "k1": 0.05, "second": {"k1": 0.0, "fl_x": 262.5}})
    source = ilf.open_source(tmp_path)
    first, second = source
    assert (first.intrinsics.fx, first.intrinsics.cx, second.intrinsics.fx) == (131.25, 79.5, 262.5)
    assert "lens distortion of colour and depth is not corrected" in first.notes[0]
    assert second.notes == ()


@pytest.mark.parametrize("size", [{}, {"w": 2 * W, "h": 2 * H}], ids=["of the image", "stated"])
def test_the_angle_of_view_alone_gives_the_camera(tmp_path, size):
    angle = 2 * np.arctan(80 / 131.25)
    _transforms(tmp_path, {"camera_angle_x": angle, **size}, suffix="" if size else ".png")
    camera = ilf.open_source(tmp_path)[0].intrinsics
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((131.25, 131.25, 79.5, 59.5))


def test_the_camera_of_a_folder_is_chosen_by_name(tmp_path):
    _transforms(tmp_path, {})
    (tmp_path / "images").rename(tmp_path / "color")
    (tmp_path / "transforms.json").unlink()
    camera = {"fx": 131.25, "fy": 131.25, "cx": 79.5, "cy": 59.5}
    (tmp_path / "camera.json").write_text(json.dumps({"color": camera, "depth": camera | {"fx": 91.25}}))
    with pytest.raises(InputError, match=r"color or depth\?.*camera\.json#color"):
        ilf.open_source(tmp_path)
    assert ilf.open_source(tmp_path, intrinsics=f"{tmp_path / 'camera.json'}#color")[0].intrinsics.fx == 131.25


def test_paths_of_windows_in_lists_are_read(tmp_path):
    _transforms(tmp_path, dict(PINHOLE), separator="\\")
    source = ilf.open_source(tmp_path)
    assert source.keys == ("images/f0", "images/f1")
    assert source[0].intrinsics.fx == 131.25
    for kind, image in (("rgb", "images"), ("depth", "depth")):
        (tmp_path / f"{kind}.txt").write_text(f"1.0 {image}\\f0.png\n2.0 {image}\\f1.png\n")
    (tmp_path / "transforms.json").unlink()
    listed = ilf.open_source(tmp_path, encoding="mm", intrinsics=(131.25, 131.25, 79.5, 59.5))
    assert np.array_equal(listed[1].depth, source[1].depth)
    meta = {"depth_units_per_m": 1000, "rgb": "images\\f0.png", "depth": "depth\\f0.png"}
    (tmp_path / "meta.json").write_text(json.dumps(meta))
    assert np.array_equal(ilf.load_frame(tmp_path).depth, source[0].depth)

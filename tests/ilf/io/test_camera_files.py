"""Files with intrinsics, as programs and people write them."""

import json
from pathlib import Path

import pytest

from ilf.errors import FormatError, IlfError, InputError
from ilf.io.cameras import frame_camera, intrinsics_from

SHAPE = (120, 160)
CAMERA = [131.25, 127.5, 80.5, 58.25]
K = [131.25, 0.0, 80.5, 0.0, 127.5, 58.25, 0.0, 0.0, 1.0]
P = [131.25, 0.0, 80.5, 44.8, 0.0, 127.5, 58.25, 0.2, 0.0, 0.0, 1.0, 0.0]
FLAT = "fx: 131.25\n{0}fy: 127.5\n{0}cx: 80.5\n{0}cy: 58.25\n"
INFRARED = "ir:\n  model: pinhole\n  fx: 91.25\n  fy: 91.25\n  cx: 64.0\n  cy: 53.0\n"
OPENCV = """%YAML:1.0
---
image_width: 160
image_height: 120
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 131.25, 0., 80.5, 0., 127.5, 58.25, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0.27, -1.3, 0., 0., 1.88 ]
"""
ORB = '%YAML:1.0\n\n# colour\nCamera.type: "PinHole"\nCamera1.fx: 131.25 # px\nCamera1.fy: 127.5\nCamera1.cx: 80.5\n'
KALIBR = f"cam0:\n  camera_model: pinhole\n  intrinsics: {CAMERA}\n  resolution: [160, 120]\n"
KITTI = f"calib_time: 09-Jan-2012 13:57:47\nS_02: 160 120\nK_02: {' '.join(map(str, K))}\n"
TABLE = "width,height,fx,fy,cx,cy\n320,240,262.5,255.0,161.5,117.0\n"
LARGE = {"width": 1280, "height": 960, "ppx": 647.5, "ppy": 469.5, "fx": 1050.0, "fy": 1020.0}
ROW = " ".join(map(str, P))
MATRIX = OPENCV.partition("camera_matrix")[2].partition("distortion")[0]
WRITTEN = {
    "section.yaml": "camera:\n  width: 1280\n  height: 960\n  fx: 1050.0\n  fy: 1020.0\n  cx: 647.5\n  cy: 469.5\n",
    "comments.yml": "# D435\nxres: 160   # px\nyres: 120\n" + FLAT.format(""),
    "byte order mark.txt": "\ufeff" + FLAT.format(""),
    "opencv.yaml": OPENCV,
    "no header.yaml": OPENCV.partition("---\n")[2],
    "vins.yaml": "model_type: PINHOLE\nimage_width: 160\nimage_height: 120\nprojection_parameters:\n  "
    + FLAT.format("  "),
    "open3d.json": json.dumps({"intrinsic_matrix": [131.25, 0, 0, 0, 127.5, 0, 80.5, 58.25, 1], "width": 160}),
    "kitti.txt": KITTI,
    "camera.pincam": "320 240 262.5 255.0 161.5 117.0\n",
    "tum.txt": "# fx fy cx cy d0 d1 d2 d3 d4\n131.25 127.5 80.5 58.25 0.26 -0.95 0.01 0.002 1.16\n",
    "named numbers.txt": "width height fx fy cx cy\n160 120 131.25 127.5 80.5 58.25\n",
    "numbers.txt": "131.25 127.5 80.5 58.25\n",
    "table.csv": TABLE,
    "projection.txt": " ".join(map(str, P)),
    "assigned.txt": "# Middlebury\ncam0=[131.25 0 80.5; 0 127.5 58.25; 0 0 1]\nwidth=160\nheight=120\n",
    "sections.conf": "[LEFT_CAM_VGA]\n" + FLAT.format("").replace(": ", "="),
    "calibration.yml": OPENCV.replace("---\n", '---\ncalibration_time: "Tue 05 Mar 10:33:00"\n# +fix_aspectRatio\n')
    + 'image_points: !!opencv-matrix\n   rows: 1\n   cols: 1\n   dt: "2f"\n   data: [ 1.9e-01, 2. ]\n',
    "no blanks.yaml": f"%YAML:1.0\nLEFT.K: !!opencv-matrix\n  rows:3\n  cols:3\n  data:{K}\n",
    "by column.json": json.dumps({"w": 160, "h": 120, "K": [131.25, 0, 0, 0, 127.5, 0, 80.5, 58.25, 1]}),
    "by row.json": json.dumps({"intrinsic_matrix": [K[:3], K[3:6], K[6:]]}),
    "flow.yaml": f"{{K: {CAMERA}}}\n",
    "tabs.yaml": "camera:\n\t" + FLAT.format("\t"),
    "lines.txt": "fx 131.25\nfy 127.5\ncx 80.5\ncy 58.25\n",
    "size as text.yaml": "resolution: 320x240\nfx: 262.5\nfy: 255.0\ncx: 161.5\ncy: 117.0\n",
    "size beside.yaml": "image: {width: 320, height: 240}\nrgb: {fx: 262.5, fy: 255.0, cx: 161.5, cy: 117.0}\n",
    "basalt.json": json.dumps(
        {"resolution": [[640, 480]] * 2, "intrinsics": [{"fx": 525, "fy": 510, "cx": 323.5, "cy": 234.5}]}
    ),
    "anchors.yaml": "common: &size\n  width: 160\n  height: 120\nrgb:\n  <<: *size\n  " + FLAT.format("  "),
}  # fmt: skip


def _numbers(camera) -> list[float]:
    return [camera.fx, camera.fy, camera.cx, camera.cy]


def _written(folder: Path, name: str, content: str) -> Path:
    path = folder / name
    path.write_text(content, "utf-8")
    return path


@pytest.mark.parametrize("name", WRITTEN)
def test_a_file_with_one_camera_gives_it(tmp_path, name):
    path = _written(tmp_path, name, WRITTEN[name])
    assert _numbers(intrinsics_from(path, SHAPE)) == pytest.approx(CAMERA)


def test_two_cameras_are_a_question_that_a_name_answers(tmp_path):
    rig = _written(tmp_path, "rig.yaml", "rgb:\n  model: pinhole\n  " + FLAT.format("  ") + INFRARED)
    with pytest.raises(InputError, match=r"rgb or ir\?.*rig\.yaml#rgb"):
        intrinsics_from(rig, SHAPE)
    assert _numbers(intrinsics_from(f"{rig}#rgb", SHAPE)) == CAMERA
    assert intrinsics_from(f"{rig}#ir", SHAPE).fx == 91.25
    with pytest.raises(FormatError, match=r"no camera 'left'.*rgb or ir"):
        intrinsics_from(f"{rig}#left", SHAPE)
    rows = _written(tmp_path, "rows.yaml", f"rgb: {CAMERA}\nroi: [0, 0, 160, 120]\n")
    assert _numbers(intrinsics_from(f"{rows}#rgb", SHAPE)) == CAMERA
    same = _written(tmp_path, "with#mark.txt", "131.25 127.5 80.5 58.25")
    assert _numbers(intrinsics_from(str(same))) == CAMERA


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (json.dumps({"depth": {"intrinsics": LARGE}, "color": {"intrinsics": LARGE | {"fx": 900.0}}}), "depth"),
        (f"- name: ir\n  K: {[91.25, *CAMERA[1:]]}\n- name: rgb\n  K: {CAMERA}\n", "rgb"),
        (KALIBR + KALIBR.replace("cam0", "cam1").replace("131.25", "91.25"), "cam0"),
        (ORB + "Camera1.cy: 58.25\nCamera2.fx: 91.0\nCamera2.fy: 91.0\nCamera2.cx: 80\nCamera2.cy: 60.0\n", "Camera1"),
        ("1 PINHOLE 160 120 131.25 127.5 81 58.75\n2 PINHOLE 160 120 91.25 91.25 80 60\n", "1"),
        (json.dumps({f"{n}.png": {**LARGE, "fx": 1050.0 + n} for n in (0, 1)}), "0.png"),
        (f"P0: {ROW}\nP2: {ROW.replace('131.25', '91.25')}\nTr: {'0.1 ' * 12}", "P0"),
        (json.dumps({"K_color": K, "K_depth": [91.25, *K[1:]]}), "K_color"),
        (json.dumps({"K": K, "K_depth": [91.25, *K[1:]]}), "top"),
        (f"color_intrinsics: {CAMERA}\ndepth_intrinsics: {[91.25, *CAMERA[1:]]}\n", "color_intrinsics"),
        (json.dumps({"cameraData": [[n, {**LARGE, "fx": fx}] for n, fx in ((0, 900), (1, 1050.0))]}), "CAM_B"),
        (f"%YAML:1.0\n---\nM1{MATRIX.replace('131.25', '91.25')}M2{MATRIX}", "M2"),
    ],
    ids=["realsense", "list", "kalibr", "orb-slam", "colmap", "by image", "kitti", "letters", "top", "four", "depthai",
         "stereo of opencv"],
)  # fmt: skip
def test_cameras_of_a_rig_are_chosen_and_never_mixed(tmp_path, content, name):
    path = _written(tmp_path, "rig.json" if content[0] == "{" else "rig.yaml", content)
    with pytest.raises(InputError, match="has 2 cameras"):
        intrinsics_from(path)
    assert _numbers(intrinsics_from(f"{path}#{name}", SHAPE)) == pytest.approx(CAMERA)


def test_keys_of_two_cameras_are_not_one(tmp_path):
    halves = "rgb:\n  fx: 131.25\n  fy: 127.5\nir:\n  cx: 64.0\n  cy: 53.0\n"
    with pytest.raises(FormatError, match="contains no camera"):
        intrinsics_from(_written(tmp_path, "halves.yaml", halves))
    sizes = "rgb:\n  " + FLAT.format("  ") + "depth:\n  width: 80\n  height: 60\n"
    assert _numbers(intrinsics_from(_written(tmp_path, "sizes.yaml", sizes), SHAPE)) == CAMERA


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("twice.yaml", FLAT.format("") + "# depth\n" + FLAT.format("").replace("131", "91")),
        ("twice.yaml", "rgb:\n  " + FLAT.format("  ") + "rgb:\n  " + FLAT.format("  ").replace("131", "91")),
        ("twice.yaml", OPENCV + "camera_matrix" + MATRIX.replace("131", "91")),
        ("twice.json", '{"fx": 91, "fy": 131, "fx": 131, "cx": 80.5, "cy": 58.25}'),
        ("twice.ini", (FLAT.format("") + FLAT.format("").replace("131", "91")).replace(":", " =")),
        ("twice.xml", "<a>" + "".join(f"<fx>{n}</fx><fy>131</fy><cx>79</cx><cy>59</cy>" for n in (1, 2)) + "</a>"),
    ],
)  # fmt: skip
def test_what_is_stated_twice_is_refused(tmp_path, name, content):
    with pytest.raises(FormatError, match=r"twice\.\w+ .*(camera_matrix|rgb|fx)"):
        intrinsics_from(_written(tmp_path, name, content), SHAPE)


@pytest.mark.parametrize(
    "content",
    [
        "fx: [", "a: " + "[" * 5_000, "%YAML:1.0\n---\nfx: [", "%YAML:1.0\n---\na: " + "[" * 20_000, "<a>",
        "<!--" * 100_000, "<?" * 100_000, "<!DOCTYPE a>", "{", "words only\n", "1 2 3", "525 525 319.5 239.5 640 480",
        "!!python/object/apply:os.system ['false']", "fx: 1\n" * 60_000, "[camera]\nfx=a\n",
        "a: &a {x: 1}\nb: &b {<<: [*a, *a]}\n" + "".join(f"c{n}: &b {{<<: [*b, *b]}}\n" for n in range(40)),
        "fx: wide\nfy: 1\ncx: 2\ncy: 3\n", f"K: {[*K[:8], 2.0]}\n", f"K: {[0.0] * 9}\n", "{\"depth\": " * 5_000,
        f"K: [.nan, 0, 319.5, 0, 525, 239.5, 0, 0, 1]\nP: {[*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0]}\n",
    ],
    ids=lambda content: content[:12],
)  # fmt: skip
def test_a_damaged_file_is_one_sentence_with_its_name(tmp_path, content):
    path = _written(tmp_path, "camera.yaml", content)
    with pytest.raises(IlfError, match=r"camera\.yaml"):
        intrinsics_from(path, SHAPE)


@pytest.mark.parametrize(
    ("stated", "note"),
    [
        ({"rgbDistortion": {"k1": 0.1, "k2": 0.0}, "depthDistortion": {"k1": 0.0}}, "distortion"),
        ({"coeffs": [0.1, 0, 0, 0, 0], "model": "distortion.inverse_brown_conrady"}, "distortion"),
        ({"k1": 0.05, "camera_model": "OPENCV"}, "distortion"),
        ({"coeffs": [0.0] * 5, "model": 2}, ""),
        ({"k1": 0.05, "camera_model": "OPENCV_FISHEYE"}, "fisheye"),
        ({"camera_model": "EQUIRECTANGULAR"}, "EQUIRECTANGULAR"),
        ({"camera_model": "pinhole", "distortion_model": "equidistant"}, "fisheye"),
        ({"coeffs": [0.1, 0, 0, 0, 0], "model": 5}, "fisheye"),
        ({"cameraType": 1, "distortionCoeff": [0.0] * 14}, "fisheye"),
        ({"cameraType": 1}, ""),
        ({"fisheye_model": 1}, "fisheye"),
        ({"camera_type": "kb4"}, "fisheye"),
        ({"type": "pinhole", "distortion": {"type": "equidistant", "parameters": [0.0] * 4}}, "fisheye"),
        ({"distortion": {"type": "radial-tangential", "parameters": {"rows": 1, "data": [0.1, 0.0]}}}, "distortion"),
        ({"dist": [[0.1, 0.0, 0.0, 0.0, 0.0]]}, "distortion"),
        ({"dist_coeff": [[0.0] * 5]}, ""),
        ({"width": 320, "height": 240}, "320 x 240"),
    ],
)
def test_lens_and_size_are_noted(tmp_path, stated, note):
    factor = 2 if "width" in stated else 1
    numbers = {"fx": 131.25 * factor, "fy": 127.5 * factor, "cx": 81 * factor - 0.5, "cy": 58.75 * factor - 0.5}
    path = _written(tmp_path, "camera.json", json.dumps(numbers | stated))
    camera, notes = frame_camera(str(path), SHAPE)
    assert len(notes) == bool(note)
    assert note in "".join(notes)
    is_pinhole = note in {"", "distortion", "320 x 240"}
    assert (_numbers(camera) == CAMERA) if is_pinhole else camera is None
    if not is_pinhole:
        with pytest.raises(InputError, match=note):
            intrinsics_from(path, SHAPE)


@pytest.mark.parametrize("numbers", ["500,5 500,5 80,25 60,75", "500,498;498,5;320,25;240,75"])
def test_decimal_commas_are_refused(tmp_path, numbers):
    (tmp_path / "k.txt").write_text(numbers)
    with pytest.raises(FormatError, match="decimal points"):
        intrinsics_from(tmp_path / "k.txt")

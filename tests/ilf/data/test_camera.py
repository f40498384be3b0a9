"""Intrinsics: presets, the forms in which people hold numbers, and scaling."""

import json

import numpy as np
import pytest

from ilf.data.camera import INTRINSICS, Camera
from ilf.errors import IlfError, InputError
from ilf.io.cameras import intrinsics_from

NUMBERS = [500.0, 510.0, 320.5, 240.25]
MATRIX = [[500.0, 0, 320.5], [0, 510.0, 240.25], [0, 0, 1]]


def numbers_of(camera: Camera) -> list[float]:
    return [camera.fx, camera.fy, camera.cx, camera.cy]


@pytest.mark.parametrize("name", INTRINSICS)
def test_preset_at_its_own_size_is_unchanged(name):
    width, height = INTRINSICS[name].size
    assert intrinsics_from(name, (height, width)) == INTRINSICS[name].pinhole
    assert 0.3 < INTRINSICS[name].cx / width < 0.7
    assert 0.3 < INTRINSICS[name].cy / height < 0.7


@pytest.mark.parametrize(
    "spec",
    [
        NUMBERS,
        tuple(NUMBERS),
        np.array(NUMBERS),
        "500, 510, 320.5, 240.25",
        dict(zip(("fx", "fy", "cx", "cy"), NUMBERS, strict=True)),
        {"K": NUMBERS},
        {"K": MATRIX},
        {"K": [x for row in MATRIX for x in row]},
        {"intrinsic_matrix": np.transpose(MATRIX).ravel().tolist(), "width": 640, "height": 480},
        {"intrinsic_matrix": MATRIX},
        {"K": np.transpose(MATRIX).tolist()},
        MATRIX,
        np.array(MATRIX),
    ],
    ids=lambda spec: str(spec)[:30],
)
def test_every_form_gives_the_same_camera(spec, tmp_path):
    assert numbers_of(intrinsics_from(spec, (480, 640))) == NUMBERS
    if isinstance(spec, list | dict):
        file = tmp_path / "kamera-für-ß.json"
        file.write_text(json.dumps(spec))
        from_file = intrinsics_from(str(file), (480, 640))
        assert numbers_of(from_file) == NUMBERS
        assert from_file.name == file.name


def test_scaling_keeps_the_ray_through_every_image_corner():
    full = INTRINSICS["nyu-kinect-v1"]
    half = intrinsics_from("NYU-Kinect-v1", (240, 320))
    # the image's left and right borders lie half a pixel outside the first and last pixel centres
    assert (-0.5 - half.cx) / half.fx == pytest.approx((-0.5 - full.cx) / full.fx)
    assert (319.5 - half.cx) / half.fx == pytest.approx((639.5 - full.cx) / full.fx)
    assert (239.5 - half.cy) / half.fy == pytest.approx((479.5 - full.cy) / full.fy)


def test_other_aspect_ratio_is_refused_with_the_way_out():
    with pytest.raises(InputError, match=r"640 x 480.*848 x 480.*aspect.*fx,fy,cx,cy"):
        intrinsics_from("nyu-kinect-v1", (480, 848))


def test_unknown_preset_suggests_the_nearest_and_lists_all():
    with pytest.raises(InputError, match="Did you mean kinect-v2") as caught:
        intrinsics_from("kinect-2")
    assert all(name in str(caught.value) for name in INTRINSICS)


@pytest.mark.parametrize(
    "spec",
    [
        "1,2,3", "a,b,c,d", "500,500,nan,240", "", [1, 2, 3], [[1, 2], [3]], [0, 500, 320, 240],
        [1e-300, 1e-300, 320, 240], [500, 500, 1e300, 240], [-500, 500, 320, 240], ["500", "500", "320", "240"],
        [None] * 4, [10**400, 1, 1, 1], {"fx": 500}, {"K": "500,500,320,240"},
        {"K": [[500, 1, 320], [0, 500, 240], [0, 0, 1]]}, {"intrinsic_matrix": [1, 2]}, 42, True,
        {"K": NUMBERS, "width": "wide", "height": 480}, {"K": NUMBERS, "width": 0, "height": 480},
    ],
    ids=lambda spec: str(spec)[:30],
)  # fmt: skip
def test_nonsense_is_refused(spec):
    with pytest.raises(IlfError):
        intrinsics_from(spec, (480, 640))

"""Depth in files of floats: EXR, PFM, COLMAP, NPZ, and disparity."""

import sys
import warnings

import cv2
import numpy as np
import pytest

import ilf
from ilf.errors import DepthWarning, FormatError, InputError, ParameterError
from ilf.io.depth import read_depth_values
from ilf.io.encodings import encoding_of, encoding_of_inputs
from tests.ilf.depth_files import colmap, exr, npy, npz, pfm
from tests.ilf.image_files import write_rgbd

H, W = 24, 32
METRES = (1.5 + 0.01 * np.arange(W)[None] + 0.02 * np.arange(H)[:, None]).astype(np.float32)
METRES[4:8, 6:12] = 0


@pytest.fixture
def save(tmp_path):
    return lambda name, content: write_rgbd(tmp_path, content, name, (H, W))


HALF = METRES.astype(np.float16)
WRITTEN = {
    "z.exr": lambda: (exr({"Z": METRES}), METRES),
    "half.exr": lambda: (exr({"Y": HALF}), HALF),
    "grey.exr": lambda: (exr({"RGB": np.dstack([HALF] * 3)}), HALF),
    "opaque.exr": lambda: (exr({"Y": METRES, "A": np.ones_like(METRES)}), METRES),
    "red.exr": lambda: (exr({"RGB": np.dstack([METRES, 0 * METRES, 0 * METRES])}), METRES),
    "layers.exr": lambda: (exr({"View.Depth.Z": METRES, "View.R": METRES + 1}), METRES),
    "blender.exr": lambda: (
        exr(
            {"ViewLayer.Depth.Z": METRES, "ViewLayer.Denoising Depth.Z": METRES + 1}
            | {f"ViewLayer.{name}": METRES + 2 for name in ("Combined.R", "Normal.X", "Normal.Z", "Position.Z")}
        ),
        METRES,
    ),
    "unreal.exr": lambda: (
        exr(
            {f"QueueWorldDepth.{name}": METRES for name in "RGB"}
            | dict.fromkeys(("QueueWorldDepth.A", *"RGBA"), METRES + 1)
        ),
        METRES,
    ),
    "little.pfm": lambda: (pfm(METRES), METRES),
    "big.pfm": lambda: (pfm(METRES, "2.5"), METRES),
    "only.npz": lambda: (npz(anything=METRES), METRES),
    "several.npz": lambda: (npz(depth=METRES, mask=METRES > 1), METRES),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_floats_are_metres_and_not_doubted(save, name):
    content, values = WRITTEN[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frame = ilf.load_frame(*save(name, content))
    assert np.array_equal(np.nan_to_num(frame.depth), values.astype(np.float32))
    assert (frame.notes, frame.inputs.depth_units) == ((), 1.0)


def test_pfm_is_what_opencv_writes(save, tmp_path):
    assert cv2.imwrite(str(tmp_path / "depth.pfm"), METRES)
    assert np.array_equal(read_depth_values(tmp_path / "depth.pfm"), METRES)


def test_colmap_is_read_with_a_doubt_of_its_unit(save):
    values = METRES.copy()
    values[0, 0] = -1
    files = save("a.png.geometric.bin", colmap(values))
    with pytest.warns(DepthWarning, match="unit of their reconstruction"):
        frame = ilf.load_frame(*files)
    assert np.array_equal(np.isnan(frame.depth), values <= 0)
    assert ilf.load_frame(*files, encoding="m").notes == ()
    assert np.nanmax(ilf.load_frame(*files, depth_units=2).depth) == METRES.max() / 2


_VIEWER_TABLE = """Frame Info:
Type,Depth
Format,{kind}
Resolution x,{width}
Resolution y,{height}
Bytes per pix,2

Intrinsic:,
Fx,30.500000
Fy,30.250000
PPx,15.5
PPy,11.5
Distorsion,Brown Conrady
"""


def test_a_snapshot_of_the_realsense_viewer_has_the_size_and_camera_of_its_table(save, tmp_path):
    stored = np.rint(1000 * METRES).astype("<u2")
    files = save("one_Depth.raw", stored.tobytes())
    with pytest.raises(FormatError, match=r"one_Depth_metadata\.csv.*missing"):
        ilf.load_frame(*files)
    table = tmp_path / "one_Depth_metadata.csv"
    for wrong in ({"kind": "Y16"}, {"width": W + 1}, {"height": -H}, {"width": "many"}, {"kind": "Z1\r6"}):
        table.write_text(_VIEWER_TABLE.format(**{"kind": "Z16", "width": W, "height": H} | wrong), newline="")
        with pytest.raises(FormatError, match="one_Depth"):
            ilf.load_frame(*files)
    table.write_text(_VIEWER_TABLE.format(kind="Z16", width=W, height=H))
    frame = ilf.load_frame(*files, intrinsics=table)
    assert np.array_equal(np.nan_to_num(frame.depth), (stored / 1000).astype(np.float32))
    assert frame.intrinsics.numbers == (30.5, 30.25, 15.5, 11.5)


def test_disparity_becomes_depth(save, tmp_path):
    disparity = np.divide(52.5, METRES, out=np.full_like(METRES, np.inf), where=METRES > 0)
    frame = ilf.load_frame(*save("disparity.pfm", pfm(disparity)), encoding="disparity:52.5")
    assert np.allclose(np.nan_to_num(frame.depth), METRES, atol=1e-5)
    assert frame.inputs.encoding == "disparity:52.5"
    assert encoding_of_inputs(frame.inputs) == encoding_of("disparity:52.5")
    assert "disparity of a stereo pair" in encoding_of("disparity:52.5").text
    whole = ilf.load_frame(
        *save("d.npy", npy(np.nan_to_num(np.rint(256 * disparity), posinf=0).astype(np.int32))),
        encoding=f"disparity:{256 * 52.5}",
    )
    assert np.allclose(np.nan_to_num(whole.depth), METRES, atol=1e-3)
    for wrong, told in {
        "disparity": "focal length",
        "disparity:0": "disparity:FB",
        "disparity:x": "disparity:FB",
    }.items():
        with pytest.raises(ParameterError, match=told):
            encoding_of(wrong)


DAMAGED = {
    "cut.pfm": (lambda: pfm(METRES)[:-1], "3071 bytes after its header, which declares 3072"),
    "longer.pfm": (lambda: pfm(METRES) + b" ", "3073 bytes after its header, which declares 3072"),
    "colours.pfm": (lambda: pfm(METRES, kind=b"PF"), "three channels"),
    "huge.pfm": (lambda: b"Pf 100000 100000 -1\n", "100000 x 100000 pixels"),
    "damaged.pfm": (lambda: b"Pf x 2 -1\n", "begins as a PFM image, but is damaged"),
    "not.pfm": (lambda: b"P5 2 2 255\n", "not a PFM"),
    "cut.bin": (lambda: colmap(METRES)[:-4], "3068 bytes after its header, which declares 3072"),
    "normals.bin": (lambda: colmap(METRES, 3), "3 channels"),
    "huge.bin": (lambda: b"100000&100000&1&", "100000 x 100000 pixels"),
    "not.bin": (lambda: bytes(100), "width&height&1&"),
    "zero.bin": (lambda: b"0&0&1&", "must have the shape"),
    "cut.exr": (lambda: exr({"Z": METRES})[:-100], "is damaged: reading this EXR"),
    "start.exr": (lambda: exr({"Z": METRES})[:100], "is damaged: reading this EXR"),
    "not.exr": (lambda: bytes(100), "not an EXR"),
    "huge.exr": (lambda: _of_size(exr({"Z": METRES}), 100_000), "100000 x 100000 pixels"),
    "wide.exr": (lambda: exr({f"c{i}": np.zeros((2, 2), "f2") for i in range(5)}), "channels c0.*which one is depth"),
    "part.exr": (lambda: _of_size(exr({"Z": METRES}), 8), "only a part"),
    "picture.exr": (lambda: exr({"RGB": np.dstack([HALF, HALF + 1, HALF])}), "this is colour, not depth"),
    "many.npz": (lambda: npz(a=METRES, b=METRES), "no array named depth.*: it has a, b\\. Save .* as depth\\."),
    "cut.npz": (lambda: npz(depth=METRES)[:-30], "NPZ cannot be read"),
}


def _of_size(content: bytes, size: int) -> bytes:
    """With a data window of another size in the header."""
    end = content.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    return content[: end + 8] + np.array([size - 1] * 2, "<i4").tobytes() + content[end + 16 :]


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_and_hostile_files_are_told_of_in_one_line(save, name, capfd):
    make, told = DAMAGED[name]
    files = save(name, make())
    with pytest.raises(FormatError, match=told) as raised:
        ilf.load_frame(*files)
    assert name in str(raised.value)
    assert "\n" not in str(raised.value)
    assert capfd.readouterr() == ("", "")


def test_without_the_package_its_extra_is_named(save, monkeypatch):
    files = save("z.exr", exr({"Z": METRES}))
    monkeypatch.setattr("ilf._runtime.children.run_in_child", lambda read, content, **_: read(content))
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(InputError, match=r"ilf-studio\[sensors\]"):
        ilf.load_frame(*files)

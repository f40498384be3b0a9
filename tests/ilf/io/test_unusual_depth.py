"""Depth that is no image file: organised clouds, PCL's images, HDF5, raw floats of a Kinect v2, photos of phones."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import h5py
import numpy as np
import pytest

import ilf
from ilf.errors import FormatError
from ilf.io.depth import read_depth_values
from ilf.io.images import read_colour
from ilf.io.pcl_files import lzf_decompressed
from tests.ilf.depth_files import pcd, pclzf
from tests.ilf.image_files import write_file

H, W = 6, 8
DEPTH = (1 + np.arange(H * W, dtype=np.float32).reshape(H, W) / 100).astype(np.float32)
DEPTH[2, 3] = np.nan
COLOUR = np.arange(H * W * 3, dtype=np.uint8).reshape(H, W, 3)


@pytest.mark.parametrize("kind", ["ascii", "binary", "binary_compressed"])
def test_organised_clouds_are_colour_and_depth(tmp_path, kind):
    path = tmp_path / "a.pcd"
    path.write_bytes(pcd(kind, DEPTH, COLOUR))
    assert np.allclose(read_depth_values(path), DEPTH, equal_nan=True)
    assert np.array_equal(read_colour(path), COLOUR)
    source = ilf.open_source(tmp_path)
    assert (source.keys, source.layout.partition(" ")[0]) == (("a",), "pcd")
    assert np.allclose(source[0].depth, DEPTH, equal_nan=True)
    content = path.read_bytes()
    for wrong, message in (
        (content[:-9], "truncated|read|damaged"),
        (content.replace(b"FIELDS x y z", b"FIELDS x y w"), "no field z"),
        (content.replace(b"HEIGHT 6", b"HEIGHT 1").replace(b"WIDTH 8", b"WIDTH 48"), "not organised"),
        (content.replace(b"SIZE 4", b"SIZE 3"), "header is damaged"),
        (content.replace(b"WIDTH 8", b"WIDTH 900000").replace(b"HEIGHT 6", b"HEIGHT 900000"), "GB of memory"),
        (content.replace(b"DATA", b"DATE"), "not a PCD"),
    ):
        path.write_bytes(wrong)
        with pytest.raises(FormatError, match=message):
            read_depth_values(path)


@pytest.mark.parametrize("labels", [b" 0.0 1.5", b" nan nan", b" -1 99999", b" 0 0\n"])
def test_a_cloud_is_read_with_other_numbers_as_integers_or_empty_lines(labels, tmp_path):
    path = tmp_path / "a.pcd"
    path.write_bytes(pcd("ascii", DEPTH, COLOUR).replace(b" 0 0\n", labels + b"\n"))
    assert np.allclose(read_depth_values(path), DEPTH, equal_nan=True)


def test_images_of_pcl_are_a_source(tmp_path):
    millimetres = np.nan_to_num(DEPTH * 1000).astype("<u2")
    files = {name: tmp_path / f"frame_20130717T175216.303267{name}" for name in ("_rgb.pclzf", "_depth.pclzf", ".xml")}
    files["_depth.pclzf"].write_bytes(pclzf("depth16", millimetres.tobytes(), W, H))
    files["_rgb.pclzf"].write_bytes(pclzf("rgb24", COLOUR.transpose(2, 0, 1).tobytes(), W, H))
    numbers = {"focal_length_x": 12, "focal_length_y": 12, "principal_point_x": 3.5, "principal_point_y": 2.5}
    lines = "".join(f"\t\t<{name}>{value}</{name}>\n" for name, value in numbers.items())
    files[".xml"].write_text(f"<?xml version='1.0'?>\n<rgb>\n{lines}</rgb>\n<depth>\n{lines}</depth>\n")
    source = ilf.open_source(tmp_path)
    frame = source[0]
    assert source.layout.startswith("pclzf")
    assert np.array_equal(np.nan_to_num(frame.depth * 1000).round(), millimetres)
    assert np.array_equal(frame.rgb, COLOUR)
    assert (frame.intrinsics.fx, frame.intrinsics.cx) == (12, 3.5)
    for content, message in (
        (pclzf("rgb24", COLOUR.tobytes(), W, H), "not depth16"),
        (pclzf("depth16", millimetres.tobytes(), 9, H), "header is damaged"),
        (pclzf("depth16", millimetres.tobytes(), W, H)[:-3], "truncated"),
        (b"PCLZF", "not a PCLZF"),
    ):
        files["_depth.pclzf"].write_bytes(content)
        with pytest.raises(FormatError, match=message):
            read_depth_values(files["_depth.pclzf"])


def test_lzf_copies_from_what_it_has_written():
    # 3 literal bytes; 5 from 3 back, which overlaps itself; 12 from 1 back
    packed = b"\x02abc" + bytes([3 << 5, 2]) + bytes([7 << 5, 3, 0])
    assert lzf_decompressed("file", packed, 20) == b"abcabcab" + b"b" * 12
    for wrong in (packed[:-1], packed + b"\x05a", bytes([1 << 5, 9]) + packed, b""):
        with pytest.raises(FormatError, match="is damaged"):
            lzf_decompressed("file", wrong, 20)


def test_raw_floats_of_a_kinect_v2_are_millimetres(tmp_path):
    values = np.linspace(4500, 500, 424 * 512, dtype="<f4").reshape(424, 512)
    values[0] = 0
    write_file(tmp_path / "rgb.png", np.zeros((424, 512, 3), np.uint8))
    for name in ("depth.raw", "depth.bin"):
        (tmp_path / name).write_bytes(values.tobytes())
        frame = ilf.load_frame(tmp_path / "rgb.png", tmp_path / name)
        assert (frame.depth[-1, -1], frame.inputs.depth_units) == (0.5, 1000)
        assert np.isnan(frame.depth[0]).all()
    (tmp_path / "depth.raw").write_bytes(values.tobytes()[:-4])
    with pytest.raises(FormatError, match="512 x 424 float32"):
        read_depth_values(tmp_path / "depth.raw")


def test_one_channel_may_be_an_axis_and_hdf5_is_read(tmp_path):
    for depth in (DEPTH[..., None], DEPTH[None]):
        np.save(tmp_path / "a.npy", depth)
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file["depth"] = depth
        for name in ("a.npy", "a.h5"):
            assert np.array_equal(read_depth_values(tmp_path / name), DEPTH, equal_nan=True)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["depth"], file["other"] = DEPTH.astype(np.float16), np.zeros(3)
    assert read_depth_values(tmp_path / "a.h5").dtype == np.float16
    with h5py.File(tmp_path / "b.hdf5", "w") as file:
        file["normals"] = np.zeros((H, W, 3))
    with pytest.raises(FormatError, match="has no datasets that can be depth"):
        read_depth_values(tmp_path / "b.hdf5")
    (tmp_path / "b.hdf5").write_bytes(b"no HDF5")
    with pytest.raises(FormatError, match="not a complete HDF5"):
        read_depth_values(tmp_path / "b.hdf5")


# Photos: no tool at hand writes HEIC with depth, so a stand-in for pillow-heif gives what it gives for a real one.


class _Image:
    def __init__(self, values: np.ndarray, metadata: dict[str, float] | None) -> None:
        self._values, self.info = values, {"metadata": metadata}
        self.size = values.shape[1], values.shape[0]

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        return self._values


@pytest.fixture
def photo(tmp_path, monkeypatch):
    def show(values: np.ndarray | None, metadata: dict[str, float] | None = None, shape=(2 * H, 2 * W)) -> Path:
        colour = np.broadcast_to(np.uint8(90), (*shape, 3)).copy()
        images = [] if values is None else [_Image(values, metadata)]
        opened = SimpleNamespace(
            mode="RGB", size=shape[::-1], data=colour.tobytes(), stride=3 * shape[1], info={"depth_images": images}
        )
        module = ModuleType("pillow_heif")
        module.open_heif = lambda file, convert_hdr_to_8bit: opened  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "pillow_heif", module)
        monkeypatch.setattr("ilf._runtime.children.run_in_child", lambda read, content, **_: read(content))
        (tmp_path / "a.heic").write_bytes(b"\0\0\0\x18ftypheic")
        return tmp_path / "a.heic"

    return show


@pytest.mark.parametrize(
    "metadata",
    [
        {"representation_type": 1, "d_min": 0.5, "d_max": 2.0},
        {"representation_type": 0, "z_near": 0.5, "z_far": 2.0},
        {"representation_type": 2, "z_near": 0.5, "z_far": 2.0},
    ],
    ids=["disparity", "inverse depth", "depth"],
)
def test_depth_of_photos_becomes_metres(photo, metadata):
    values = np.linspace(0, 255, H * W).astype(np.uint8).reshape(H, W)
    path = photo(values, metadata)
    frame = ilf.open_source(path.parent)[0]
    assert (frame.shape, frame.rgb.shape) == ((H, W), (H, W, 3)), "colour comes to the pixels of depth"
    first, last = (0.5, 2.0) if metadata["representation_type"] == 2 else (2.0, 0.5)
    assert (frame.depth[0, 0], frame.depth[-1, -1]) == (pytest.approx(first), pytest.approx(last))


@pytest.mark.parametrize("accuracy", ["relative", "absolute"])
def test_photos_whose_depth_is_relative_say_so(photo, accuracy):
    """Apple's word for depth of two lenses, which is not absolutely accurate; with a laser or TrueDepth it is."""
    values = np.linspace(0, 255, H * W).astype(np.uint8).reshape(H, W)
    path = photo(values, {"representation_type": 1, "d_min": 0.5, "d_max": 2.0})
    path.write_bytes(path.read_bytes() + f"<depthData:Accuracy>{accuracy}</depthData:Accuracy>".encode())
    found = ilf.load_frame(path, path, warn=False).plausibility_warnings
    assert any("relative" in text for text in found) == (accuracy == "relative")
    assert not ilf.load_frame(path, path, encoding="m").plausibility_warnings


def test_photos_without_metres_are_refused(photo):
    values = np.zeros((H, W), np.uint8)
    for given, message in (((None,), "has no depth image"), ((values, {}), "does not state how its depth becomes")):
        with pytest.raises(FormatError, match=message):
            read_depth_values(photo(*given))
    with pytest.raises(FormatError, match="another view"):
        read_colour(photo(values, {}, (2 * W, 2 * H)))


def test_photos_are_read_in_a_child_and_damaged_ones_refused(tmp_path):
    heif = pytest.importorskip("pillow_heif")
    grey = np.full((64, 96, 3), 90, np.uint8)
    path = tmp_path / "a.heic"
    heif.from_bytes("RGB", (96, 64), grey.tobytes()).save(path)
    assert np.abs(read_colour(path).astype(int) - grey).max() < 5
    path.write_bytes(path.read_bytes()[:400])
    with pytest.raises(FormatError, match=f"{path} is damaged: reading this HEIC fails"):
        read_colour(path)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(FormatError, match="a PNG"):
        read_colour(path)

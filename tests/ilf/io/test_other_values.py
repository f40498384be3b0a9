"""Values that are no depth: z-buffers, normalised depth, and distances along rays, which must be doubted aloud."""

from pathlib import Path

import h5py
import numpy as np
import pytest

import ilf
from ilf._runtime.files import read_file
from ilf.io.depth import read_depth
from tests.ilf.image_files import write_rgbd

NEAR, FAR = 0.1, 10.0
SHAPE = 60, 80


def depth() -> np.ndarray:
    """A floor and walls, 2 to 5 m [m], and where nothing was hit: inf."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    metres = 2 + 0.02 * (SHAPE[0] - rows) + 0.02 * np.abs(columns - 40) + 0.0
    metres[:10, 30:60] = np.inf
    return metres


def z_buffer(metres: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(metres), FAR / (FAR - NEAR) * (1 - NEAR / metres), 1.0)


def normalised(metres: np.ndarray) -> np.ndarray:
    low, high = metres.min(), metres[np.isfinite(metres)].max()
    return np.where(np.isfinite(metres), (metres - low) / (high - low), 1.0)


VALUES = {
    "z-buffer": z_buffer(depth()),
    "z-buffer without background": z_buffer(np.where(np.isfinite(depth()), depth(), 4.0)),
    "reversed z-buffer": 1 - z_buffer(depth()),
    "reversed z-buffer, near plane at 1 m": np.where(np.isfinite(depth()), 1 / depth(), 0),
    "normalised": normalised(depth()),
    "normalised by the largest": np.where(np.isfinite(depth()), depth() / 4.1, 1.0),
    "normalised with another background": np.where(np.isfinite(depth()), depth() / 8, 0.9),
    "8 bits, divided": np.where(np.isfinite(depth()), np.rint(51 * depth()) / 255, 0),
    "16 bits of 0.1 mm, divided": np.where(np.isfinite(depth()), np.rint(1e4 * depth()) / 65535, 0),
    "inverse, normalised": np.where(np.isfinite(depth()), depth().min() / depth(), 0),
}


def files(folder: Path, values: np.ndarray, name: str = "depth.npy") -> tuple[Path, Path]:
    return write_rgbd(folder, values, name)


def told(paths: tuple[Path, Path], **options) -> str:
    """Warnings and errors of loading a frame."""
    try:
        return " ".join(ilf.load_frame(*paths, warn=False, **options).plausibility_warnings)
    except ilf.IlfError as error:
        return str(error)


@pytest.mark.parametrize("values", VALUES.values(), ids=list(VALUES))
@pytest.mark.parametrize("kind", ["depth.npy", "depth.exr", "float64", "depth.png"])
def test_values_from_0_to_1_are_doubted(kind, values, tmp_path):
    if kind == "depth.png":
        written, name = np.rint(65535 * values).astype(np.uint16), kind
    else:
        written, name = (
            values.astype(kind if kind == "float64" else np.float32),
            "depth.npy" if "." not in kind else kind,
        )
    paths = files(tmp_path, written, name)
    text = told(paths)
    if kind == "depth.png" and written.max() < 65535:
        assert text, "some doubt about the unit"
    else:
        assert "z-buffer" in text or "inverse depth" in text
    assert "z-buffer" not in told(paths, encoding="mm" if kind == "depth.png" else "m")


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_z_buffer_that_is_the_other_way_round_is_doubted(is_reversed, tmp_path):
    values = 1 - z_buffer(depth()) if is_reversed else z_buffer(depth())
    paths = files(tmp_path, values.astype(np.float32))
    way, other = f"zbuffer:{NEAR},{FAR}", f"zbuffer:{NEAR},{FAR},reversed"
    right, wrong = (other, way) if is_reversed else (way, other)
    assert told(paths, encoding=wrong).endswith(f"Give {right}.")
    assert not told(paths, encoding=right)


@pytest.mark.parametrize("right", ["rgb24", "bgr24"])
def test_bits_in_three_channels_that_are_read_the_other_way_round_are_doubted(right, tmp_path):
    whole = np.rint(np.where(np.isfinite(depth()), depth() / 1000, 1) * (2**24 - 1)).astype(int)
    channels = [whole & 255, whole >> 8 & 255, whole >> 16]
    image = np.dstack(channels[::-1] if right == "rgb24" else channels).astype(np.uint8)
    rgb, bits = files(tmp_path, image, "bits.png")
    wrong = "bgr24" if right == "rgb24" else "rgb24"
    with pytest.raises(ilf.IlfError, match=rf"100 for centimetres.*Give {right}:1000\.0"):
        ilf.load_frame(rgb, bits, encoding=f"{wrong}:1000")
    assert not told((rgb, bits), encoding=f"{right}:1000")


@pytest.mark.parametrize("scale", [1, 1.5, 4.5])
def test_inverse_depth_in_16_bits_is_doubted_whatever_its_median(scale, tmp_path):
    rows = np.linspace(0.2, 1, 240)[:, None] + np.zeros(320)  # of a floor, from 5 m to 1 m
    for values, is_inverse in ((1000 * scale * rows, True), (1000 * scale / rows, False)):
        assert ("inverse depth" in told(files(tmp_path, values, "depth.png"))) == is_inverse


@pytest.mark.parametrize("factor", [1.0, 0.4])
def test_depth_in_metres_is_not_doubted(factor, tmp_path):
    metres = np.where(np.isfinite(depth()), factor * depth() / (1.0 if factor == 1 else 2.5), 0)
    assert not told(files(tmp_path, metres.astype(np.float32)))


DISTANCES = (
    "distance_to_camera_0001.npy",
    "range.npy",
    "depth-euclidean.npy",
    "distance_to_camera/0001.npy",
    "ranges/1.npy",
    "DepthPerspective/7.npy",
    "img_depth_perspective_7.npy",
    "1078543892_depthMap.exr",  # of AliceVision
)
DEPTHS = (
    "distance_to_image_plane_0001.npy",
    "orange.npy",
    "arrange/1.npy",
    "range_test/depth.npy",
    "strange_1.npy",
    "7_depthMap.npy",
)


@pytest.mark.parametrize("name", DISTANCES)
def test_ray_is_proposed_where_the_name_says_distance(name, tmp_path):
    paths = files(tmp_path, np.where(np.isfinite(depth()), depth(), 0).astype(np.float32), name)
    with pytest.warns(ilf.DepthWarning, match="ray:UNITS,FX,FY,CX,CY"):
        ilf.load_frame(*paths)
    assert not told(paths, encoding="ray:1,50,50,40,30")


@pytest.mark.parametrize("name", ["distance_to_camera_1.npy", "DepthPerspective_1.npy"])
def test_distances_by_a_makers_name_are_converted_where_the_camera_is_known(name, tmp_path):
    distances = np.where(np.isfinite(depth()), depth(), 0).astype(np.float32)
    paths = files(tmp_path, distances, name)
    frame = ilf.load_frame(*paths, intrinsics=(50, 50, 40, 30))
    assert np.array_equal(frame.depth, ilf.load_frame(*paths, encoding="ray:1,50,50,40,30").depth, equal_nan=True)


def test_a_dataset_that_says_distance_is_doubted_too(tmp_path):
    rgb, _ = files(tmp_path, np.ones(depth().shape, np.float32), "unused.npy")
    with h5py.File(tmp_path / "0.hdf5", "w") as file:
        file["distance"] = file["depth"] = np.where(np.isfinite(depth()), depth(), 0).astype(np.float32)
    assert "ray:UNITS" in told((rgb, Path(f"{tmp_path}/0.hdf5:/distance")))
    assert not told((rgb, tmp_path / "0.hdf5"))


@pytest.mark.parametrize("name", DEPTHS)
def test_ray_is_not_proposed_for_other_names(name, tmp_path):
    assert not told(files(tmp_path, np.where(np.isfinite(depth()), depth(), 0).astype(np.float32), name))


@pytest.mark.parametrize("share", [0.1, 0.0])
def test_values_that_go_down_to_nothing_are_doubted_as_inverse_depth(tmp_path, share):
    """Depth Anything gives inverse depth of 0 to 7.25, and near 0 for what is far."""
    values = np.tile(np.geomspace(7.25, 1.5, SHAPE[1]), (SHAPE[0], 1)).astype(np.float32)
    far = int(share * SHAPE[0])
    values[:far] = np.random.default_rng(0).uniform(0.001, 0.03, (far, SHAPE[1]))
    assert ("disparity:FB" in told(files(tmp_path, values))) == (share > 0)


@pytest.mark.parametrize(
    ("name", "is_doubted"),
    [
        ("disp0", True),
        ("left_disparity", True),
        ("disp_occ_0/000000_10", True),
        ("disparity/left/0006", True),
        ("display", False),
        ("from_disparity/0001", False),
    ],
)
def test_a_name_that_says_disparity_is_doubted(tmp_path, name, is_doubted):
    """Disparity of a small image, 4 to 10 px, would be plausible metres."""
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    disparity = np.where(np.isfinite(depth()), 20 / depth(), np.inf).astype(np.float32)
    colour, file = files(tmp_path, disparity[::-1], f"{name}.npy")
    notes = ilf.load_frame(colour, file, warn=False).notes
    assert any("disparity:FB" in note for note in notes) == is_doubted
    read = ilf.load_frame(colour, file, encoding="disparity:20", warn=False)
    assert read.depth[read.known] == pytest.approx(depth()[::-1][read.known])
    assert not read.notes


@pytest.mark.parametrize(
    ("kind", "values", "scale", "is_doubted"),
    [
        ("npz", np.uint16(10_000), 0.0001, True),
        ("npz", np.uint16(10_000), 0.1, True),  # in mm, as of BOP
        ("attribute", np.uint16(5000), 5000.0, True),
        ("number", np.uint16(4000), 0.25, True),
        ("number", np.uint16(10_000), np.array([0.0001]), True),
        ("npz", np.uint16(10_000), "0.1 mm", True),
        ("attribute", np.uint16(100), b"centimetres", True),
        ("attribute", np.uint16(1000), "Millimeter", False),
        ("attribute", np.uint16(10_000), "steps", False),
        ("npz", np.uint16(1000), 0.001, False),
        ("attribute", np.uint16(1000), 1.0, False),
        ("number", np.float32(1), 0.001, False),  # of the sensor: depth is in metres already
    ],
)
def test_a_scale_inside_the_file_that_would_change_depth_is_doubted(kind, values, scale, is_doubted, tmp_path):
    depth = (np.linspace(0.5, 0.8, 48 * 64).reshape(48, 64) * values).astype(values.dtype)
    path = tmp_path / ("d.npz" if kind == "npz" else "d.h5")
    if kind == "npz":
        np.savez(path, depth=depth, depth_scale=scale)
    else:
        with h5py.File(path, "w") as file:
            dataset = file.create_dataset("depth", data=depth)
            (dataset.attrs if kind == "attribute" else file)["depth_scale"] = scale
    read = read_depth(read_file(path))
    assert any("depth_scale" in text for text in read.warnings) == is_doubted
    assert not any("depth_scale" in text for text in read_depth(read_file(path), given=2000.0).warnings)


def test_few_scattered_pixels_may_be_of_a_lidar(tmp_path):
    metres = np.nan_to_num(depth(), posinf=0)
    kept = np.random.default_rng(2).random(SHAPE) < 0.02
    paths = files(tmp_path, np.where(kept, 256 * metres, 0).astype(np.uint16), "depth.png")
    assert "(mm, kitti)" in told(paths)
    assert not told(paths, encoding="kitti")
    assert not told(files(tmp_path / "dense", (1000 * metres).astype(np.uint16), "depth.png"))


@pytest.mark.parametrize(("least", "is_mark"), [(0.1, True), (1.8, False)])
def test_a_value_far_below_all_other_depth_marks_what_is_missing(least, is_mark, tmp_path):
    values = np.where(np.isfinite(depth()), depth(), least).astype(np.float32)
    paths = files(tmp_path, values)
    assert ("invalid value" in told(paths)) == is_mark
    assert not told(paths, invalid=least if is_mark else None)


def test_hypersim_is_along_rays_by_its_name(tmp_path):
    rgb, _ = files(tmp_path, np.ones(SHAPE, np.float32), "unused.npy")
    for name, is_along_rays in (("frame.0003.depth_meters.hdf5", True), ("frame_3.hdf5", False)):
        with h5py.File(tmp_path / name, "w") as file:
            file["dataset"] = np.nan_to_num(depth(), posinf=0).astype(np.float32)
        assert ("ray:UNITS" in told((rgb, tmp_path / name))) == is_along_rays


def test_a_scale_inside_the_file_comes_before_guesses(tmp_path):
    multiples_of_8 = (8 * np.arange(1500, 1500 + 48 * 64)).astype(np.uint16).reshape(48, 64)  # as of rotated bits
    np.savez(tmp_path / "d.npz", depth=multiples_of_8, depth_scale=0.0001)
    assert any("10000" in text for text in read_depth(read_file(tmp_path / "d.npz")).warnings)

"""Orientation tags of one file of a pair: applied where only so colour and depth show the same pixels, and said."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

import ilf
from ilf.project.sources import load_inputs

TURNED = {
    2: np.fliplr,
    3: lambda a: np.rot90(a, 2),
    4: np.flipud,
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: np.rot90(a, 2).swapaxes(0, 1),
    8: np.rot90,
}
STORED = {tag: TURNED[{6: 8, 8: 6}.get(tag, tag)] for tag in TURNED}


def scene(height: int = 96, width: int = 128) -> tuple[np.ndarray, np.ndarray]:
    """Colour and depth [mm] of boxes before a wall, which look different from every side."""
    colour, depth = np.full((height, width, 3), 90, np.uint8), np.full((height, width), 3000, np.uint16)
    for n, (top, left, tall, wide) in enumerate([(8, 10, 30, 22), (50, 20, 12, 40), (20, 70, 50, 9), (70, 80, 18, 14)]):
        part = slice(top, top + tall), slice(left, left + wide)
        colour[part], depth[part] = (200, 40 * n, 30), 1500 + 200 * n
    return colour, depth


def save(path: Path, image: np.ndarray, tag: int) -> Path:
    """Save an image as stored, with an orientation tag."""
    picture = Image.fromarray(np.ascontiguousarray(image))
    if path.suffix == ".tif":
        picture.save(path, tiffinfo={274: tag})
    else:
        exif = Image.Exif()
        exif[274] = tag
        picture.save(path, exif=exif, **({"quality": 95} if path.suffix == ".jpg" else {}))
    return path


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("tag", TURNED)
@pytest.mark.parametrize("size", [(96, 128), (128, 128)])
def test_colour_with_a_tag_is_turned_to_upright_depth(tag, size, tmp_path):
    colour, depth = scene(*size)
    rgb = save(tmp_path / "rgb.jpg", STORED[tag](colour), tag)
    frame = ilf.load_frame(rgb, save(tmp_path / "depth.png", depth, 1))
    assert np.abs(frame.rgb.astype(int) - colour).mean() < 4
    assert np.allclose(frame.depth, depth / 1000)
    assert any("rgb.jpg" in note and str(tag) in note for note in frame.notes)
    again = load_inputs(frame.inputs, frame.name, None)
    assert np.array_equal(again.rgb, frame.rgb)


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("tag", TURNED)
@pytest.mark.parametrize("name", ["depth.tif", "depth.png"])
def test_depth_with_a_tag_is_turned_to_upright_colour(tag, name, tmp_path):
    colour, depth = scene()
    file = save(tmp_path / name, STORED[tag](depth), tag)
    frame = ilf.load_frame(save(tmp_path / "rgb.png", colour, 1), file)
    assert np.array_equal(frame.rgb, colour)
    assert np.allclose(frame.depth, depth / 1000)
    assert any(name in note and str(tag) in note for note in frame.notes)
    assert np.allclose(load_inputs(frame.inputs, frame.name, None).depth, frame.depth)


@pytest.mark.parametrize("tag", TURNED)
def test_files_with_the_same_tag_stay_as_stored(tag, tmp_path):
    colour, depth = map(STORED[tag], scene())
    frame = ilf.load_frame(save(tmp_path / "rgb.png", colour, tag), save(tmp_path / "depth.png", depth, tag))
    assert np.array_equal(frame.rgb, colour)
    assert np.allclose(frame.depth, depth / 1000)
    assert not frame.notes


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("tag", [2, 3, 4])
@pytest.mark.parametrize("is_room", [False, True])
def test_a_tag_that_does_not_apply_is_left_out_and_said(tag, is_room, tmp_path):
    colour, depth = scene()
    if is_room:  # a wall with a pattern above a plain floor
        colour[:56] += np.random.default_rng(0).integers(0, 7, (56, 128, 1), np.uint8)
        depth[56:] = np.minimum(depth[56:], np.linspace(3000, 900, 40)[:, None])
    frame = ilf.load_frame(save(tmp_path / "rgb.png", colour, tag), save(tmp_path / "depth.png", depth, 1))
    assert np.array_equal(frame.rgb, colour)
    assert any("as stored" in note for note in frame.notes)
    assert not frame.plausibility_warnings


@pytest.mark.parametrize(("tag", "said"), [(2, "mirrored"), (3, "180"), (4, "upside down"), (6, "90 degrees")])
def test_depth_that_is_turned_without_a_tag_is_doubted(tag, said, tmp_path):
    colour, depth = scene(128, 128)
    rgb = save(tmp_path / "rgb.png", colour, 1)
    assert not ilf.load_frame(rgb, save(tmp_path / "right.png", depth, 1)).notes
    np.save(tmp_path / "depth.npy", STORED[tag](depth))
    with pytest.warns(ilf.DepthWarning, match=said):
        assert ilf.load_frame(rgb, tmp_path / "depth.npy").plausibility_warnings


def test_a_tag_that_nothing_decides_is_doubted(tmp_path):
    colour, depth = scene()
    rgb = save(tmp_path / "rgb.png", np.full_like(colour, 90), 3)
    with pytest.warns(ilf.DepthWarning, match=r"rgb\.png has the orientation tag 3"):
        frame = ilf.load_frame(rgb, save(tmp_path / "depth.png", depth, 1))
    assert frame.plausibility_warnings


def test_sizes_that_differ_either_way_name_the_tag(tmp_path):
    colour, depth = scene()
    rgb = save(tmp_path / "rgb.jpg", colour[:-4], 6)
    with pytest.raises(ilf.IlfError, match="orientation tag 6"):
        ilf.load_frame(rgb, save(tmp_path / "depth.png", depth, 1))
    with pytest.raises(ilf.IlfError, match="turned by 90 degrees"):
        ilf.load_frame(save(tmp_path / "rgb.png", STORED[6](colour), 1), tmp_path / "depth.png")


def save_hdf5(path: Path, depth: np.ndarray, **attributes: str) -> Path:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("depth", data=depth.astype(np.float32) / 1000).attrs.update(attributes)
    return path


@pytest.mark.parametrize("size", [(96, 128), (128, 128)])
def test_rows_and_columns_that_matlab_has_exchanged(size, tmp_path):
    colour, depth = scene(*size)
    rgb = save(tmp_path / "rgb.png", colour, 1)
    named = save_hdf5(tmp_path / "named.h5", depth.T, MATLAB_class="single")
    plain = save_hdf5(tmp_path / "plain.hdf5", depth)
    for file in (named, plain):
        frame = ilf.load_frame(rgb, file)
        assert np.allclose(frame.depth, depth / 1000)
        assert not frame.notes
    written = save_hdf5(tmp_path / "written.h5", depth.T)
    with pytest.warns(ilf.DepthWarning, match=r"written\.h5 .*MATLAB"):
        frame = ilf.load_frame(rgb, written)
    assert np.allclose(frame.depth, depth / 1000)
    assert np.allclose(load_inputs(frame.inputs, frame.name, None).depth, frame.depth)
    if size[0] == size[1]:
        with pytest.raises(ilf.IlfError, match="rows and columns exchanged"):
            ilf.load_frame(rgb, plain, ground_truth=written)
        symmetric = save_hdf5(tmp_path / "symmetric.hdf5", depth / 2 + depth.T / 2)
        assert ilf.load_frame(rgb, plain, ground_truth=symmetric).ground_truth is not None
    else:
        assert np.allclose(ilf.load_frame(rgb, plain, ground_truth=written).ground_truth, depth / 1000)


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("is_from_top", [False, True])
def test_rows_of_pfm_are_also_read_as_airsim_writes_them(is_from_top, tmp_path):
    colour, depth = scene()
    metres = (depth / 1000).astype("<f4")
    rows = metres if is_from_top else np.flipud(metres)
    (tmp_path / "depth.pfm").write_bytes(b"Pf\n128 96\n-1.000000\n" + np.ascontiguousarray(rows).tobytes())
    frame = ilf.load_frame(save(tmp_path / "rgb.png", colour, 1), tmp_path / "depth.pfm")
    assert np.array_equal(frame.depth, metres)
    assert any("AirSim" in note for note in frame.notes) == is_from_top
    assert np.array_equal(load_inputs(frame.inputs, frame.name, None).depth, metres)
    plain = save(tmp_path / "plain.png", np.full_like(colour, 90), 1)
    assert not ilf.load_frame(plain, tmp_path / "depth.pfm").notes, "nearly all are from the bottom up"


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("suffix", [".pfm", ".h5"])
def test_a_tag_of_colour_goes_before_the_order_of_rows(suffix, tmp_path):
    colour, depth = scene()
    metres = (depth / 1000).astype("<f4")
    file = tmp_path / f"depth{suffix}"
    if suffix == ".h5":
        with h5py.File(file, "w") as stored:
            stored["depth"] = metres
    else:
        file.write_bytes(b"Pf\n128 96\n-1\n" + np.flipud(metres).tobytes())
    frame = ilf.load_frame(save(tmp_path / "rgb.jpg", STORED[6](colour), 6), file)
    assert np.abs(frame.rgb.astype(int) - colour).mean() < 4
    assert np.array_equal(frame.depth, metres)


def test_a_square_that_nothing_decides_is_doubted(tmp_path):
    colour, depth = scene(128, 128)
    rgb = save(tmp_path / "rgb.png", np.full_like(colour, 90), 1)
    with pytest.warns(ilf.DepthWarning, match="MATLAB"):
        assert ilf.load_frame(rgb, save_hdf5(tmp_path / "depth.h5", depth)).plausibility_warnings


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
@pytest.mark.parametrize("tag", [1, *TURNED])
@pytest.mark.parametrize("is_upright", [False, True])
def test_photos_of_phones_are_upright_unless_depth_is_not(tag, is_upright, tmp_path):
    heif = pytest.importorskip("pillow_heif")
    colour, depth = scene()
    exif = Image.Exif()
    exif[274] = tag
    photo = heif.from_pillow(Image.fromarray(colour))
    photo.info["exif"] = exif.tobytes()
    try:
        photo.save(tmp_path / "rgb.heic", quality=95)
    except RuntimeError:
        pytest.skip("this pillow-heif cannot encode")
    turn = TURNED.get(tag, np.asarray) if is_upright else np.asarray
    frame = ilf.load_frame(tmp_path / "rgb.heic", save(tmp_path / "depth.png", turn(depth), 1))
    assert np.allclose(frame.depth, turn(depth) / 1000)
    assert np.abs(frame.rgb.astype(int) - turn(colour)).mean() < 6
    assert bool(frame.notes) == (tag != 1)

"""Depth in HDF5 and MATLAB files: which dataset is read, how it is named, and the same frame again from records."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

import ilf
from ilf._runtime.files import split_dataset
from ilf.cli import main
from ilf.errors import FormatError, InputError
from ilf.io.depth import read_depth_values
from ilf.io.images import encode_image, read_colour
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.sources.frame_ref import FrameRef, ReadingOptions
from ilf.sources.reading import read_frame

H, W = 24, 32
NEAR = np.linspace(1, 2, H * W, dtype=np.float32).reshape(H, W)
FAR = NEAR + 3


@pytest.fixture
def folder(tmp_path):
    """A colour image and an HDF5 file with two images that can be depth, and much that cannot."""
    colour = np.random.default_rng(0).integers(0, 255, (H, W, 3), np.uint8)
    (tmp_path / "rgb.png").write_bytes(encode_image(".png", colour))
    with h5py.File(tmp_path / "take.h5", "w") as file:
        file["left/depth"], file["right/z"] = NEAR, FAR
        file["camera"], file["points"] = np.eye(4), np.zeros((500, 3))
        file["mask"], file["colour"] = np.zeros((H, W), np.uint8), np.zeros((H, W, 3), np.float32)
        file["alias"] = h5py.SoftLink("/left/depth")
    return tmp_path


def test_several_are_listed_with_what_to_write(folder):
    path = folder / "take.h5"
    with pytest.raises(FormatError) as error:
        ilf.load_frame(folder / "rgb.png", path)
    assert "/left/depth (24, 32), /right/z (24, 32). Name" in str(error.value), "neither matrices, masks nor links"
    assert f"{path}:/left/depth" in str(error.value), "which can be pasted"
    assert np.array_equal(ilf.load_frame(folder / "rgb.png", f"{path}:/left/depth").depth, NEAR)


@pytest.mark.parametrize("name", ["/right/z", "right/z"])
def test_a_dataset_is_named_behind_the_file_or_as_option(folder, name):
    for frame in (
        ilf.load_frame(folder / "rgb.png", folder / "take.h5:" / name.lstrip("/")),
        ilf.load_frame(folder / "rgb.png", folder / "take.h5", dataset=name),
        read_frame(FrameRef(str(folder / "rgb.png"), f"{folder}/take.h5:\\right\\z")),
    ):
        assert np.array_equal(frame.depth, FAR)
        assert frame.inputs.depth.path == str(folder / "take.h5"), "the file alone, so that it is found again"


@pytest.mark.parametrize(
    ("path", "wanted"),
    [
        ("C:/a/take.h5:/depth", ("C:/a/take.h5", "/depth")),
        (r"C:\a\take.MAT:\left\depth", (r"C:\a\take.MAT", "/left/depth")),
        ("12:30 take.hdf5:/a:b", ("12:30 take.hdf5", "/a:b")),
        ("https://host:80/a.h5:/depth", ("https://host:80/a.h5", "/depth")),
        ("https://my.h5:8080/depth.png", ("https://my.h5:8080/depth.png", None)),
        ("zip://a.h5::/all.zip", ("zip://a.h5::/all.zip", None)),
        ("C:/depth.h5", ("C:/depth.h5", None)),
        ("depth.png:/depth", ("depth.png:/depth", None)),
    ],
)
def test_only_a_name_behind_hdf5_is_taken_for_a_dataset(path, wanted):
    assert split_dataset(path) == wanted


def test_a_file_that_has_such_a_path_is_read_as_it_is(folder):
    shutil.copytree(folder, folder / "odd.h5:", ignore=lambda *_: ["odd.h5:"])
    with h5py.File(folder / "odd.h5:/only.h5", "w") as file:
        file["depth"] = FAR
    assert np.array_equal(ilf.load_frame(folder / "rgb.png", folder / "odd.h5:/only.h5").depth, FAR)


@pytest.mark.parametrize(
    ("name", "message"), [("/nothing", "has no image /nothing. It has: /left"), ("/alias", "link"), ("/mask", "8-bit")]
)
def test_what_is_no_depth_is_refused_by_its_name(folder, name, message):
    with pytest.raises(FormatError, match=message):
        ilf.load_frame(folder / "rgb.png", folder / "take.h5", dataset=name)


def test_a_dataset_of_what_has_none_is_refused(folder):
    np.save(folder / "depth.npy", NEAR)
    with pytest.raises(FormatError, match="no HDF5 file"):
        ilf.load_frame(folder / "rgb.png", folder / "depth.npy", dataset="/depth")


@pytest.mark.parametrize("is_stored_as_matlab", [True, False])
def test_the_order_of_axes_of_matlab_is_undone_also_in_squares(folder, is_stored_as_matlab):
    square = NEAR[:, :H]
    with h5py.File(folder / "depth.mat", "w", userblock_size=512) as file:
        file["scene/z"] = square.T
        file["scene/z"].attrs["MATLAB_class"] = np.bytes_("single")
        file["#refs#/a"] = square
    if is_stored_as_matlab:
        with open(folder / "depth.mat", "r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" "))
    assert np.array_equal(read_depth_values(folder / "depth.mat"), square)
    assert np.array_equal(read_depth_values(folder / "depth.mat", dataset="/scene/z"), square)


@pytest.mark.parametrize("first", [False, True])
def test_colour_beside_depth_is_read_as_blenderproc_writes_it(tmp_path, first):
    """Also with opacity and the channels first; depth beyond all is what was not hit."""
    colour = np.random.default_rng(0).integers(0, 255, (H, W, 4 if first else 3), np.uint8)
    for name in ("0.hdf5", "1.hdf5"):
        with h5py.File(tmp_path / name, "w") as file:
            file["colors"] = np.moveaxis(colour, 2, 0) if first else colour
            file["depth"] = np.where(NEAR > 1.1, NEAR, np.float32(1e10))
    source = ilf.open_source(tmp_path)
    frame = read_frame(source.ref("0"))
    assert source.layout.startswith("blenderproc")
    assert len(source) == 2
    assert np.array_equal(frame.rgb, colour[..., :3])
    assert np.array_equal(frame.depth, np.where(NEAR > 1.1, NEAR, np.nan), equal_nan=True)
    assert not any("column" in note for note in frame.notes)


@pytest.mark.parametrize(("name", "told"), [("distance", "ray:UNITS,FX,FY,CX,CY"), ("disparity", "disparity:FB")])
def test_what_is_no_depth_by_its_name_is_read_only_by_it(tmp_path, name, told):
    """BlenderProc writes distance, by enable_distance_output, instead of depth or beside it; Spring has disparity."""
    path = tmp_path / "0.hdf5"
    with h5py.File(path, "w") as file:
        file["colors"], file[name] = np.full((H, W, 3), 90, np.uint8), NEAR
    with pytest.raises(FormatError, match=rf"no depth.*0\.hdf5:/{name}"):
        ilf.load_frame(path, path)
    with pytest.warns(ilf.errors.DepthWarning, match=told):
        ilf.load_frame(path, f"{path}:/{name}")
    np.savez(tmp_path / "0.npz", **{name: NEAR})
    with pytest.raises(FormatError, match="no array named depth"):
        ilf.load_frame(path, tmp_path / "0.npz")
    np.savez(tmp_path / "0.npz")
    with pytest.raises(FormatError, match="it has none"):
        ilf.load_frame(path, tmp_path / "0.npz")
    with h5py.File(path, "a") as file:
        file["depth"] = FAR
    assert np.array_equal(ilf.load_frame(path, path).depth, FAR)


def test_colour_of_hdf5_that_declares_more_than_memory_is_refused_by_its_header(tmp_path):
    with h5py.File(tmp_path / "0.hdf5", "w") as file:
        file.create_dataset("colors", (3, 100_000, 100_000), np.uint8, chunks=True)
    with pytest.raises(FormatError, match="100000 x 100000"):
        read_colour(tmp_path / "0.hdf5")


def test_hdf5_without_colour_is_refused_as_colour(folder):
    with pytest.raises(FormatError, match=r"take\.h5 has no colour: no dataset colors, color, rgb, image of 8 bits"):
        ilf.load_frame(folder / "take.h5", folder / "take.h5")


def test_a_new_project_repeats_the_dataset(folder):
    files = [str(folder / "rgb.png"), f"{folder / 'take.h5'}:/right/z"]
    assert main(["project", "new", str(folder / "new.ilf"), *files]) == 0
    with ilf.open_project(folder / "new.ilf") as opened:
        assert np.array_equal(read_frame(opened.project.frames[0].source).depth, FAR)


@pytest.mark.parametrize("moved", [False, True])
def test_projects_read_two_datasets_of_a_file_as_two_frames(folder, moved):
    colour, depth = str(folder / "rgb.png"), f"{folder / 'take.h5'}:"
    state = FrameState("a1", ilf.load_frame(colour, f"{depth}/right/z"), ilf.Blocks(np.ones((H, W), np.int32)))
    refs = FrameRef.of(state.frame.inputs), FrameRef(colour, f"{depth}/left/depth")
    assert refs[0].key != refs[1].key
    frames = (
        ProjectFrame("a1", "one", refs[0], FrameSummary(Stage.UNTOUCHED), True),
        ProjectFrame("b2", "two", refs[1]),
    )
    save_project(folder / "room.ilf", Project(frames), [state])
    place = folder
    if moved:
        place = folder.with_name("elsewhere")
        folder.rename(place)
    with ilf.open_project(place / "room.ilf") as opened:
        assert np.array_equal(opened.state("a1").state.frame.depth, FAR)
        assert np.array_equal(read_frame(opened.project.frames[1].source).depth, NEAR)


def test_all_files_of_a_folder_have_the_same_dataset(folder):
    for kind, name in (("rgb", "rgb.png"), ("depth", "take.h5")):
        (folder / "set" / kind).mkdir(parents=True)
        for number in range(2):
            shutil.copy(folder / name, folder / "set" / kind / f"{number:04}{Path(name).suffix}")
    for options in (
        ReadingOptions(dataset="/right/z"),
        ReadingOptions(layout="rgb=rgb/*.png depth=depth/*.h5:/right/z"),
    ):
        source = ilf.open_source(folder / "set", **options.given)
        assert [np.array_equal(frame.depth, FAR) for frame in source] == [True, True]
    with pytest.raises(ilf.IlfError, match="2 datasets that can be depth"):
        ilf.open_source(folder / "set")[0]


def test_a_missing_file_is_named_without_its_dataset(folder):
    with pytest.raises(InputError, match=r"other\.h5: there is no such file"):
        ilf.load_frame(folder / "rgb.png", folder / "other.h5:/depth")

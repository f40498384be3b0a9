"""Writing a run: every chosen file or none, and never over the frame's own files."""

import dataclasses
import json
from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf._runtime.formatting import counted
from ilf.errors import ExportError, ParameterError
from ilf.io.depth import read_depth_values
from ilf.io.images import read_colour, read_labels
from ilf.run import writing as space_files
from ilf.run.options import ExportOptions
from ilf.run.writing import check_write, filenames, write

from ..small_runs import contents, small_run, with_invalid_mask
from ..space_formats import read_mesh, read_points

ALL = ExportOptions(depth_formats=("png", "tiff", "npy"), cloud="xyz")
BARE = replace(ALL, run_record=False)


@pytest.fixture
def run(tmp_path):
    return small_run(tmp_path)


@pytest.fixture
def completion(run):
    return run.complete()


def test_all_chosen_files_are_written_and_hold_the_result(run, completion, tmp_path):
    out = tmp_path / "deep" / "out"
    found = write(out, completion, ALL)
    assert [path.name for path in found.files] == list(filenames(run, ALL))
    assert set(contents(out)) == set(filenames(run, ALL)) == {*filenames(None, ALL), "meta.json"}
    assert found.notes == ()
    np.testing.assert_array_equal(np.load(out / "depth.npy"), completion.depth)
    np.testing.assert_array_equal(read_depth_values(out / "depth.tiff"), completion.depth)
    stored = read_depth_values(out / "depth.png") / 1000
    np.testing.assert_allclose(stored, np.nan_to_num(completion.depth), atol=0.0005001)
    np.testing.assert_array_equal(read_labels(out / "blocks.png"), run.blocks.labels)
    rows = (out / "curves.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(map(len, completion.history.values()))
    assert json.loads((out / "run.json").read_text())["program"] == "ilf-studio"


def test_what_is_asked_for_twice_is_written_once():
    options = ExportOptions(depth_formats=["npy", "png", "npy"], exports=["tum.png", "tum.png"])
    assert (options.depth_formats, options.exports) == (("npy", "png"), ("tum.png",))


def test_only_chosen_files_are_written_and_others_left_alone(run, completion, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    options = ExportOptions((), expected_error=False, labels=True, curves=False, cloud=None, run_record=False)
    write(tmp_path, completion, options)
    assert {path.name for path in tmp_path.iterdir()} == {"in", "notes.txt", "blocks.png"}
    nothing = replace(options, labels=False)
    assert filenames(run, nothing) == ()
    assert write(tmp_path / "empty", completion, nothing).files == ()


@pytest.mark.parametrize(("formats", "units"), [(("png",), 2000.0), (("png", "npy"), 2000.0), (("tiff",), 1000.0)])
def test_the_folder_opens_again_as_a_frame(run, completion, tmp_path, formats, units):
    write(tmp_path / "out", completion, replace(ALL, depth_formats=formats, depth_units=units))
    again = ilf.load_frame(tmp_path / "out")
    np.testing.assert_array_equal(again.rgb, run.frame.rgb)
    tolerance = 0 if formats != ("png",) else 0.5001 / units
    np.testing.assert_allclose(again.depth, completion.depth, rtol=0, atol=tolerance)
    assert again.intrinsics == dataclasses.replace(run.frame.intrinsics, name="")
    assert again.name == "in-completed"


def test_lost_depth_is_noted_by_file(run, completion, tmp_path):
    (note,) = write(tmp_path / "out", completion, replace(BARE, depth_units=50_000.0)).notes
    assert note.startswith("depth.png: ")
    assert "clipped" in note


def test_units_coarser_than_the_inputs_are_noted(run, completion, tmp_path):
    (note,) = write(tmp_path / "out", completion, replace(BARE, depth_units=100.0)).notes
    assert note.startswith("depth.png: The PNG has steps of 10 mm, the input has 1 mm")
    exact = replace(BARE, depth_formats=("npy",), depth_units=100.0)
    assert write(tmp_path / "out", completion, exact).notes == ()


@pytest.mark.parametrize("cloud", ["ply", "pcd"])
def test_points_tell_all_that_is_known_of_them(run, completion, tmp_path, cloud):
    options = replace(BARE, cloud=cloud, mesh="ply", cloud_unit="mm", normals=True)
    out = tmp_path / "out"
    write(out, completion, options)
    points, vertices, faces = (
        read_points(out / f"cloud.{cloud}"),
        read_points(out / "mesh.ply"),
        read_mesh(out / "mesh.ply"),
    )
    known = np.isfinite(completion.depth)
    np.testing.assert_array_equal(points["positions"][:, 2], completion.depth[known] * np.float32(1000))
    error = np.nan_to_num(ilf.expected_error(completion))
    for found, pixels in ((points, known), (vertices, _pixels_of(vertices, run, completion))):
        np.testing.assert_array_equal(found["scalar_expected_error"], error[pixels] * np.float32(1000))
        np.testing.assert_array_equal(found["quality"], found["scalar_expected_error"])
        np.testing.assert_array_equal(found["scalar_filled"], completion.filled[pixels])
        np.testing.assert_array_equal(found["scalar_block"], run.blocks.labels[pixels])
        np.testing.assert_array_equal(found["scalar_unsupported"], ilf.unsupported(completion)[pixels])
        assert all(np.isfinite(values).all() for values in found.values())
    np.testing.assert_array_equal(np.unique(faces.triangles), np.arange(len(vertices["positions"])))
    write(out, completion, replace(options, cloud="ply", expected_error=False))
    names = read_points(out / "cloud.ply").keys()
    assert "scalar_filled" in names
    assert not {"quality", "scalar_expected_error", "scalar_unsupported"} & names


def _pixels_of(vertices, run, completion):
    """Which pixels (H, W) the vertices [mm] are seen at."""
    camera, pixels = run.frame.intrinsics, np.zeros(run.frame.shape, bool)
    x, y, z = vertices["positions"].T
    rows = np.rint(y / z * camera.fy + camera.cy).astype(int)
    columns = np.rint(x / z * camera.fx + camera.cx).astype(int)
    pixels[rows, columns] = True
    np.testing.assert_array_equal(completion.depth[rows, columns] * np.float32(1000), z)
    return pixels


def test_points_in_mid_air_are_left_out_and_counted(run, completion, tmp_path):
    depth = completion.depth.copy()
    depth[20, 40] = 9.0
    flying = replace(completion, depth=depth)
    options = replace(BARE, cloud="ply", mesh="obj", drop_flying=True, depth_formats=("npy",))
    (note,) = [note for note in write(tmp_path / "out", flying, options).notes if "flying" in note]
    count = int(note.removeprefix("Left out of cloud and mesh: ").split()[0])
    left = np.count_nonzero(np.isfinite(depth)) - count
    z = read_points(tmp_path / "out" / "cloud.ply")["positions"][:, 2]
    assert len(z) == left
    assert z.max() < 9
    assert np.load(tmp_path / "out" / "depth.npy")[20, 40] == 9
    assert "\nf " in (tmp_path / "out" / "mesh.obj").read_text()


def test_guesses_and_distrusted_depth_have_masks(run, tmp_path):
    extrapolate = replace(with_invalid_mask(run), extrapolate=True, only=frozenset({2}))
    found = write(tmp_path / "out", extrapolate.complete(), BARE)
    depth = np.load(tmp_path / "out" / "depth.npy")
    extrapolated, invalid_mask = (
        read_colour(tmp_path / "out" / f"{name}.png")[..., 0] == 255 for name in ("extrapolated", "invalid_mask")
    )
    assert np.isfinite(depth).all()
    np.testing.assert_array_equal(invalid_mask, extrapolate.frame.invalid_mask)
    np.testing.assert_array_equal(extrapolated, ~extrapolate.frame.known & (extrapolate.blocks.labels == 1))
    assert f"{extrapolated.sum()} pixels" in found.notes[0]
    assert {"extrapolated.png", "invalid_mask.png"} <= set(filenames(extrapolate, BARE))
    assert not {"extrapolated.png", "invalid_mask.png"} & set(filenames(run, BARE))


def test_expected_errors_come_in_the_formats_and_units_of_the_depth(run, completion, tmp_path):
    out = tmp_path / "out"
    assert write(out, completion, replace(BARE, depth_units=1100.0)).notes == ()
    expected = ilf.expected_error(completion)
    np.testing.assert_array_equal(np.load(out / "expected_error.npy"), expected)
    np.testing.assert_array_equal(read_depth_values(out / "expected_error.tiff"), expected)
    stored = read_depth_values(out / "expected_error.png")
    np.testing.assert_array_equal(stored > 0, completion.filled)
    wanted = np.maximum(expected[completion.filled], 1 / 1100)
    np.testing.assert_allclose(stored[completion.filled] / 1100, wanted, atol=0.00046)
    np.testing.assert_array_equal(read_colour(out / "unsupported.png")[..., 0] > 0, ilf.unsupported(completion))
    outside = replace(completion, depth=np.where(completion.filled, 50, completion.depth).astype(np.float32))
    count = np.count_nonzero(completion.filled)
    assert write(out, outside, BARE).notes == (
        f"Unsupported by measurements: {counted(count, 'pixel')}, see unsupported.png.",
    )
    np.testing.assert_array_equal(read_colour(out / "unsupported.png")[..., 0] > 0, completion.filled)
    no_files = ExportOptions((), labels=False, curves=False, cloud=None)
    assert filenames(run, no_files) == ("run.json",)


def test_failing_writer_leaves_the_folder_as_it_was(run, completion, tmp_path, monkeypatch):
    out = tmp_path / "out"
    write(out, completion, ALL)
    before = contents(out)

    def fails(path, *_, **__):
        raise ExportError(f"Could not write {path}: the disk is full.")

    monkeypatch.setattr(space_files, "write_cloud", fails)
    other = replace(completion, depth=completion.depth + 1)
    with pytest.raises(ExportError) as caught:
        write(out, other, ALL)
    assert str(caught.value) == f"Could not write {out / 'cloud.xyz'}: the disk is full."
    assert contents(out) == before
    with pytest.raises(ExportError):
        write(tmp_path / "new" / "folder", completion, BARE)
    assert not (tmp_path / "new").exists()


def test_the_frames_own_files_are_never_overwritten(run, completion, tmp_path):
    own = tmp_path / "in"
    raw = (own / "depth.png").read_bytes()
    with pytest.raises(ExportError, match="own file"):
        write(own, completion, BARE)
    assert (own / "depth.png").read_bytes() == raw
    (own / "meta.json").write_text("{}")
    with pytest.raises(ExportError, match=r"meta\.json is the frame's own file"):
        write(own, completion, replace(BARE, depth_formats=("npy",)))
    assert (own / "meta.json").read_text() == "{}"


def test_a_meta_json_that_is_not_of_an_export_is_never_overwritten(run, completion, tmp_path):
    folder = tmp_path / "frame"
    folder.mkdir()
    meta = '{"rgb": "../in/rgb.png", "depth": "../in/depth.png", "depth_units_per_m": 1000}'
    (folder / "meta.json").write_text(meta)
    frame = ilf.load_frame(folder)
    with pytest.raises(ExportError, match=r"meta\.json describes a frame"):
        write(folder, replace(completion, run=replace(run, frame=frame)), replace(BARE, cloud=None))
    assert (folder / "meta.json").read_text() == meta
    write(tmp_path / "out", completion, BARE)
    write(tmp_path / "out", completion, BARE)


def test_what_cannot_be_written_is_refused(run, completion, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "odd" / "depth.npy").mkdir(parents=True)
    for folder in ("file", "file/below", "odd", "a" * 300):
        with pytest.raises(ExportError):
            write(tmp_path / folder, completion, BARE)
    assert (tmp_path / "odd" / "depth.npy").is_dir()
    assert len(list((tmp_path / "odd").iterdir())) == 1
    write(tmp_path / "out", completion, BARE)
    with pytest.raises(ExportError, match="already"):
        check_write(tmp_path / "out", run, BARE, overwrite=False)


@pytest.mark.parametrize(
    "wrong",
    [
        *({"depth_formats": ("jpg",)}, {"cloud": "obj"}, {"mesh": "stl"}, {"axes": "z"}, {"cloud_unit": "in"}),
        *({"depth_formats": "png"}, {"depth_formats": [["png"]]}, {"cloud": ["ply"]}),
        *({"depth_units": units} for units in (0.0, -1000.0, float("nan"), float("inf"))),
    ],
)
def test_unknown_choices_are_refused(wrong):
    with pytest.raises(ParameterError):
        ExportOptions(**wrong)

"""Frames, results in folders and results in shards as arrays, and as a data set of PyTorch where that is installed."""

import importlib
import os
import pickle
import shutil
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import FormatError, InputError, ParameterError
from ilf.run.data_sets import write_data_set
from ilf.run.frame_arrays import FIELDS, FrameArrays
from ilf.sources.opening import close_all

from ..batch_frames import contents, work_in_this_process, write_frames

pytest.importorskip("pyarrow")

LIBRARY = Path(__file__).parents[3] / "assets" / "docs" / "library.md"
QUICK = ["--quiet", "--max-iterations", "5", "--no-correction", "--blocks-detector", "canny", "--blocks-min-size", "20"]
CAMERA = ["--intrinsics", "30,31,16,12"]
POSE = np.eye(4) + np.eye(4, k=3) * 1.5
SHARDS, FOLDERS, FRAMES = "shards", "folders", "frames"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A folder with three frames, their results in folders and in shards, and results with other settings."""
    root = tmp_path_factory.mktemp("arrays")
    write_frames(root / FRAMES, 3)
    np.savetxt(root / FRAMES / "depth" / "0001.pose.txt", POSE)
    with pytest.MonkeyPatch.context() as patch:
        work_in_this_process(patch)
        command = ["batch", str(root / FRAMES), *QUICK, *CAMERA]
        assert main([*command, "--out", str(root / FOLDERS), "--no-cloud"]) == 0
        keep = ["--keep", "depth,expected_error,unsupported", "--per-shard", "2"]
        assert main([*command, "--shards", str(root / SHARDS), *keep]) == 0
        denoise, first = ["--mode", "fill+denoise"], ["--frames", ":1"]
        assert main([*command, "--out", str(root / "denoised"), "--no-cloud", *denoise, *first]) == 0
        assert main([*command, "--shards", str(root / "denoised-shards"), *denoise, *first]) == 0
        assert main([*command, "--out", str(root / "bare"), "--no-cloud", "--no-expected-error", *first]) == 0
    yield root
    close_all()


@pytest.fixture
def results(done, tmp_path):
    """A copy of them to be changed; their colour stays where it is."""
    return Path(shutil.copytree(done, tmp_path / "done"))


def test_frames_have_what_was_measured(done):
    arrays = FrameArrays(ilf.open_source(done / FRAMES, intrinsics=(30, 31, 16, 12)))
    assert (len(arrays), arrays.keys) == (3, ("rgb/0000", "rgb/0001", "rgb/0002"))
    assert arrays.fields == ("rgb", "depth_in", "mask", "K", "pose", "key")
    item, frame = arrays[1], ilf.open_source(done / FRAMES)["rgb/0001"]
    np.testing.assert_array_equal(item["rgb"], np.moveaxis(frame.rgb, -1, 0))
    np.testing.assert_array_equal(item["depth_in"][0], frame.depth)
    np.testing.assert_array_equal(item["mask"][0], np.isfinite(frame.depth))
    np.testing.assert_array_equal(item["K"], [[30, 0, 16], [0, 31, 12], [0, 0, 1]])
    np.testing.assert_array_equal(item["pose"], POSE)
    assert item["key"] == "rgb/0001"
    assert [item[name].dtype.name for name in arrays.fields[:-1]] == ["uint8", "float32", "bool", "float32", "float32"]
    assert all(item[name].flags.writeable and item[name].flags.c_contiguous for name in arrays.fields[:-1])
    unknown = FrameArrays(done / FRAMES)[-3]
    assert unknown["key"] == "rgb/0000"
    assert np.isnan(unknown["K"]).all()
    assert np.isnan(unknown["pose"]).all()


@pytest.mark.parametrize(("name", "keys"), [(FOLDERS, "rgb__000{}"), (SHARDS, "rgb/000{}")])
def test_results_have_depth_before_and_after(done, name, keys):
    arrays, frames = FrameArrays(done / name), FrameArrays(done / FRAMES)
    assert arrays.keys == tuple(keys.format(number) for number in range(3))
    assert set(arrays.fields) == set(FIELDS) - {"ground_truth"}
    for item, measured in zip(arrays, frames, strict=True):
        for field in ("rgb", "depth_in", "mask"):
            np.testing.assert_array_equal(item[field], measured[field])
            assert item[field].dtype == measured[field].dtype
        filled = np.isfinite(item["depth"]) & ~item["mask"]
        assert filled.any()
        np.testing.assert_array_equal(np.isfinite(item["expected_error"]), filled)
        np.testing.assert_array_equal(item["depth"][item["mask"]], item["depth_in"][item["mask"]])
        assert not item["unsupported"][item["mask"]].any()
        assert all(one.flags.writeable for one in item.values() if not isinstance(one, str))
    np.testing.assert_array_equal(arrays[1]["pose"], POSE)
    np.testing.assert_array_equal(arrays[1]["K"], [[30, 0, 16], [0, 31, 12], [0, 0, 1]])


def test_shards_and_folders_have_the_same_depth(done):
    for of_folder, of_shard in zip(FrameArrays(done / FOLDERS), FrameArrays(done / SHARDS), strict=True):
        for field in ("depth", "expected_error"):  # as NPY and as PNG in millimetres
            np.testing.assert_allclose(of_shard[field], of_folder[field], atol=1.01e-3)


@pytest.mark.parametrize("name", [FRAMES, FOLDERS, SHARDS])
def test_copies_for_other_processes_read_the_same_and_keep_no_file_open(done, name):
    arrays = FrameArrays(done / name, fields=["key", "rgb", "key"])
    copy = pickle.loads(pickle.dumps(arrays))
    before = len(os.listdir("/proc/self/fd")) if sys.platform == "linux" else 0
    for item, again in zip(arrays, copy, strict=True):
        assert (list(item), item["key"]) == (["key", "rgb"], again["key"])
        np.testing.assert_array_equal(item["rgb"], again["rgb"])
    assert not before or len(os.listdir("/proc/self/fd")) == before


def test_only_what_is_asked_for_is_read(results):
    for path in (results / FOLDERS).glob("*/expected_error.npy"):
        path.write_bytes(b"damaged")
    for path in (results / FRAMES / "rgb").glob("000[12].png"):
        path.write_bytes(b"damaged")
    assert FrameArrays(results / FOLDERS, fields=["depth", "pose"])[2]["depth"].shape == (1, 24, 32)
    with pytest.raises(FormatError, match=r"expected_error\.npy"):
        FrameArrays(results / FOLDERS, fields=["mask"])
    arrays = FrameArrays(results / FRAMES)
    assert (len(arrays), arrays[0]["key"]) == (3, "rgb/0000")
    with pytest.raises(FormatError, match=r"0001\.png"):
        arrays[1]


def test_a_frame_of_a_shard_is_read_without_the_rest_of_its_tar(results):
    arrays = FrameArrays(results / SHARDS)
    tar = min((results / SHARDS).glob("*.tar"))
    data = tar.read_bytes()
    second = data.index(b"rgb__0001.depth.png")
    tar.write_bytes(bytes(second) + data[second:])
    assert arrays[1]["key"] == "rgb/0001"
    with pytest.raises(FormatError, match="is damaged in rgb/0000"):
        arrays[0]


def test_shards_are_exported_as_folders_are(done, tmp_path):
    for name in (FOLDERS, SHARDS):
        notes = write_data_set(tmp_path / name, [done / name], "open3d").notes
        assert len(notes) == 1
        assert notes[0].startswith("Left out, without a known pose: 2 results (rgb")
    assert contents(tmp_path / FOLDERS) == contents(tmp_path / SHARDS)
    assert len(contents(tmp_path / SHARDS)) == 4


def test_fields_that_are_not_there_are_named_with_what_to_do(done, results):
    for where, field in (
        (FRAMES, "expected_error"),
        (FRAMES, "ground_truth"),
        (FOLDERS, "ground_truth"),
        ("denoised", "depth_in"),
        ("denoised-shards", "depth_in"),
        ("bare", "mask"),
        ("bare", "unsupported"),
    ):
        with pytest.raises(InputError, match=f"has no {field}. Leave this field out") as refused:
            FrameArrays(done / where, fields=[field])
        assert ("ilf batch" in str(refused.value)) == (field in {"expected_error", "unsupported"})
        assert field not in FrameArrays(done / where).fields
    with pytest.raises(ParameterError, match=r"no field 'colour'\. Known: rgb, depth_in"):
        FrameArrays(done / FRAMES, fields=["colour"])
    arrays = FrameArrays(results / FOLDERS)
    (results / FOLDERS / "rgb__0002" / "unsupported.png").unlink()
    with pytest.raises(InputError, match=r"rgb__0002 in .* has no unsupported"):
        arrays[2]
    for number in (3, -4):
        with pytest.raises(IndexError, match=f"no item {number}: it has 3, from 0 to 2"):
            arrays[number]


def test_completed_depth_is_not_taken_for_measured_depth(done):
    for name in (FOLDERS, SHARDS):
        with pytest.raises(InputError, match=r"has completed depth\. Give the folder"):
            FrameArrays(ilf.open_source(done / name))


def test_what_is_still_missing_was_not_measured(results):
    folder = results / FOLDERS / "rgb__0001"
    for name in ("depth.npy", "expected_error.npy"):
        values = np.load(folder / name)
        values[:4] = np.nan
        np.save(folder / name, values)
    item = FrameArrays(results / FOLDERS)[1]
    assert np.isnan(item["depth_in"][0, :4]).all()
    assert not item["mask"][0, :4].any()
    assert item["mask"][0, 4:].any()


def test_results_that_were_changed_are_refused(results):
    folder = results / FOLDERS / "rgb__0000"
    for name in ("unsupported.png", "expected_error.npy"):
        before = (folder / name).read_bytes()
        if name.endswith("npy"):
            np.save(folder / name, np.zeros((3, 4), np.float32))
        else:
            cv2.imwrite(str(folder / name), np.zeros((3, 4), np.uint8))
        with pytest.raises(FormatError, match=f"{name} has another size than its depth"):
            FrameArrays(results / FOLDERS)
        (folder / name).write_bytes(before)
    (folder / "run.json").write_text("[]")
    with pytest.raises(FormatError, match="is not a run record"):
        FrameArrays(results / FOLDERS, fields=["depth_in"])


def test_without_pytorch_one_line_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "ilf.torch", raising=False)
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(InputError, match=r'ilf\.torch needs the package torch.*pip install "ilf-studio\[torch\]"\.$'):
        importlib.import_module("ilf.torch")


def first_pixel(item: dict) -> dict:
    """A transform that other processes can import."""
    return {"key": item["key"], "depth": item["depth"][0, 0, 0]}


def test_the_data_set_gives_tensors_to_change(done):
    torch = pytest.importorskip("torch")
    from ilf.torch import FrameDataset

    fields = "mask", "rgb", "pose", "depth"
    data, arrays = FrameDataset(done / FOLDERS, fields), FrameArrays(done / FOLDERS, fields)
    assert (len(data), data.keys, data.fields) == (3, arrays.keys, arrays.fields)
    item = data[1]
    kinds = {name: one.dtype for name, one in item.items() if name != "key"}
    assert (kinds["rgb"], kinds["mask"], kinds["pose"]) == (torch.uint8, torch.bool, torch.float32)
    item["depth"] += 1
    np.testing.assert_array_equal(item["depth"].numpy(), arrays[1]["depth"] + 1)
    assert torch.equal(data[1]["depth"] + 1, item["depth"])


@pytest.mark.parametrize(("name", "start"), [(FRAMES, "fork"), (SHARDS, "spawn")])
def test_workers_read_it(done, name, start):
    pytest.importorskip("torch")
    from torch.utils.data import DataLoader

    from ilf.torch import FrameDataset

    transform = None if name == FRAMES else first_pixel
    data = FrameDataset(done / name, transform=transform)
    workers = 1 if start == "spawn" else 2
    batches = list(DataLoader(data, batch_size=3, num_workers=workers, multiprocessing_context=start))
    assert len(batches) == 1
    assert tuple(batches[0]["key"]) == data.keys
    expected = [data[number] for number in range(3)]
    field = "depth_in" if name == FRAMES else "depth"
    for one, item in zip(batches[0][field], expected, strict=True):
        np.testing.assert_array_equal(one, item[field])

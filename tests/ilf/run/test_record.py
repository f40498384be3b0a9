"""The run record: the same for the same run, with a word for all that it depends on, and checked when read."""

import hashlib
import importlib.metadata
import json
import math
import platform
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf._runtime.installation import asset_path
from ilf.errors import FormatError
from ilf.run.record import array_sha256, library_versions, make_record, read_record, to_json

from ..small_frames import QUICK
from ..small_runs import OPTIONS, changed, small_run, with_drawn_border, with_invalid_mask, written


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The record of a plain run, to be copied."""
    folder = tmp_path_factory.mktemp("plain")
    return written(small_run(folder), folder / "out")


@pytest.fixture
def record_path(plain, tmp_path):
    """A copy of it that may be changed."""
    return Path(shutil.copy(plain, tmp_path / "run.json"))


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_same_run_gives_same_record_without_times(tmp_path):
    first = written(small_run(tmp_path), tmp_path / "out").read_bytes()
    second = written(small_run(tmp_path), tmp_path / "other").read_bytes()
    assert first == second
    assert first.endswith(b"}\n")
    assert b"seconds" not in first
    assert str(tmp_path / "out").encode() not in first


def test_the_record_vouches_for_every_file_of_the_set(tmp_path):
    record = read_record(written(with_drawn_border(with_invalid_mask(small_run(tmp_path))), tmp_path / "out"))
    files = {path.name: sha256(path) for path in (tmp_path / "out").iterdir() if path.name != "run.json"}
    assert record.outputs == files
    assert {"meta.json", "invalid_mask.png", "drawn.png", "depth.npy", "cloud.xyz"} <= set(files)


def test_the_record_vouches_for_the_networks(tmp_path):
    run = small_run(tmp_path)
    run = run.with_parameters(run.parameters, {1: ilf.preset("paper", **QUICK)})
    record = make_record(run.complete(), OPTIONS)
    bundled = sha256(asset_path("models/edges.onnx"))
    assert record.networks.extraction == {"edges": bundled}
    assert record.networks.filter == {"edges": bundled, "correction": sha256(asset_path("models/correction.onnx"))}
    other = ilf.Run(run.frame, replace(run.blocks, own={}, network=None), ilf.preset("paper", **QUICK))
    record = make_record(other.complete(), OPTIONS)
    assert (record.networks.extraction, record.networks.filter) == ({}, {})


def test_what_is_not_a_number_becomes_null(tmp_path):
    path = written(small_run(tmp_path, parameters=ilf.preset(min_known_pixels=5000)), tmp_path / "out")
    outcomes = json.loads(path.read_text())["blocks_outcome"]
    assert {outcome["status"] for outcome in outcomes} == {"not recoverable"}
    assert {outcome["sigma_i"] for outcome in outcomes} == {None}
    record = read_record(path)
    assert all(math.isnan(outcome.sigma_i) for outcome in record.blocks_outcome)
    assert to_json(record) == path.read_bytes()


def test_hashes_of_arrays_do_not_depend_on_their_form():
    depth = np.array([[1.5, np.nan], [2, 3]], np.float32)
    other = depth.copy()
    other.view(np.uint32)[0, 1] = 0xFFC0_0001  # another NaN
    same = {array_sha256(array) for array in (depth, other, np.asfortranarray(depth), depth.astype(">f4"))}
    assert len(same) == 1
    assert array_sha256(depth + 1) not in same
    assert array_sha256(np.array([[True]])) == array_sha256(np.array([[1]], np.int64))
    assert array_sha256(np.array([1, 0])) != array_sha256(np.array([0, 1]))


def test_what_a_record_does_not_know_is_passed_over_but_not_unknown_parameters(record_path):
    for keys in (
        ["mood"],
        ["own_parameters"],
        ["blocks", "outline"],
        ["export", "colour"],
        ["blocks_outcome", 0, "defect_rate"],
    ):
        changed(record_path, *keys, "good")
    read_record(record_path)
    with pytest.raises(FormatError, match="There is no parameter 'prior'"):
        read_record(changed(record_path, "parameters", "prior", "plane"))


@pytest.mark.parametrize("schema", [0, 2, -1, "1", 1.0, True, None])
def test_another_schema_is_refused_in_one_line(record_path, schema):
    path = changed(changed(record_path, "schema", schema), "version", "9.8.7")
    with pytest.raises(FormatError) as refused:
        read_record(path)
    assert f"has schema {json.dumps(schema)};" in str(refused.value)
    assert "(9.8.7)" in str(refused.value)


@pytest.mark.parametrize(
    "keys",
    [
        *((name,) for name in ("schema", "name", "processor", "device", "networks", "invalid_mask")),
        *((name,) for name in ("drawn", "outside_view")),
        *((name,) for name in ("guide", "pose", "depth_sha256", "outputs", "extrapolate")),
        *(("export", name) for name in ("expected_error", "mesh", "normals", "drop_flying")),
        *(("inputs", name) for name in ("ground_truth", "encoding", "invalid", "frame")),
        ("blocks_outcome", 0, "outside"),
        ("parameters", "correction"),
        ("extraction", "detector"),
    ],
    ids=str,
)
def test_a_record_that_lacks_something_is_refused(record_path, keys):
    data = part = json.loads(record_path.read_text())
    for key in keys[:-1]:
        part = part[key]
    del part[keys[-1]]
    record_path.write_text(json.dumps(data))
    with pytest.raises(FormatError, match=rf"run\.json.*{keys[-1]}"):
        read_record(record_path)


@pytest.mark.parametrize(
    "damage",
    [
        ("program", "other"), ("version", 3), ("name", None), ("versions", []), ("versions", "numpy", 2),
        ("processor", None), ("inputs", 5), ("inputs", "depth_units", True), ("inputs", "depth_units", float("inf")),
        ("inputs", "intrinsics", [1, 2, 3]), ("inputs", "intrinsics", [10**400, 1, 1, 1]), ("inputs", "rgb", "rgb.png"),
        ("inputs", "depth_to_colour", [1.0] * 12),
        ("invalid_mask", {"sha256": "0", "file": "../mask.png"}), ("invalid_mask", []),
        ("drawn", {"file": "drawn.png"}), ("parameters", "smoothness", 10**400), ("parameters", "mode", "magic"),
        ("block_parameters", {"1": 5}),
        ("block_parameters", {"1": {"self": 1}}), ("extraction", []), ("extraction", "dilation", 1.5), ("networks", {}),
        ("extraction", "detector", {}), ("export", "depth_formats", [[1]]),
        ("networks", "filter", {"edges": None}), ("blocks", {}), ("blocks", "shape", [60]), ("blocks", "edited", 1),
        ("blocks", "file", "../in/depth.png"), ("extrapolate", 1), ("export", "depth_units", 10**400),
        ("export", "depth_formats", "png"), ("export", "depth_formats", [1]), ("export", "cloud", "obj"),
        ("export", "mesh", "stl"), ("export", "normals", 1), ("export", "labels", None), ("blocks_outcome", {}),
        ("blocks_outcome", 0, {}), ("blocks_outcome", 0, "status", "splendid"),
        ("blocks_outcome", 0, "pixels", 0), ("blocks_outcome", 0, "sigma_i", "0.1"),
        ("depth_sha256", None), ("outputs", {"../depth.npy": "0"}), ("outputs", {"..": "0"}),
        ("outputs", {"depth.npy": 0}),
    ],
    ids=lambda damage: str(damage)[:60],
)  # fmt: skip
def test_damaged_records_are_refused_by_name(record_path, damage):
    with pytest.raises(FormatError, match=r"run\.json") as caught:
        read_record(changed(record_path, *damage))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"3", b"\xff\xfe", b"[" * 100_000])
def test_files_that_are_no_record_are_refused(tmp_path, content):
    path = tmp_path / "run.json"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        read_record(path)


def test_versions_are_those_of_the_distribution_that_is_there(monkeypatch):
    found = {"scipy": "1.15", "onnxruntime-gpu": "1.22"}

    def version(name):
        if name not in found:
            raise importlib.metadata.PackageNotFoundError(name)
        return found[name]

    monkeypatch.setattr("ilf.run.record.version", version)
    monkeypatch.setattr("cv2.__version__", "5.0.0")
    expected = {"python": platform.python_version(), "numpy": np.__version__, "scipy": "1.15", "onnxruntime": "1.22"}
    assert library_versions() == expected | {"opencv": "5.0.0", "numba": None}


def test_whole_numbers_pass_where_any_number_does(record_path):
    units = read_record(changed(record_path, "inputs", "depth_units", 500)).inputs.depth_units
    assert (units, type(units)) == (500.0, float)


def test_the_common_parameters_are_those_of_most_blocks(tmp_path):
    run = small_run(tmp_path)
    labels = run.blocks.labels.copy()
    labels[:10, :10] = 3
    special = ilf.preset(**QUICK, mode="fill+denoise")
    mixed = replace(run, blocks=replace(run.blocks, labels=labels))
    mixed = mixed.with_parameters(run.parameters, {1: special, 3: special})
    record = make_record(mixed.complete(), OPTIONS)
    assert record.parameters == special
    assert record.own_parameters == {1: special, 2: run.parameters, 3: special}

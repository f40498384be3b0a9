"""Writing: exact round trips, the same bytes every time, and never a lost or half-written file."""

import csv
import errno
import io
import math
import os
from pathlib import Path

import numpy as np
import pytest

from ilf._runtime.writing import atomic_path, write_bytes
from ilf.data.points import PointCloud
from ilf.data.results import EdgeAwareRecord, PassBandRecord
from ilf.data.surface import Mesh
from ilf.errors import ExportError, ParameterError
from ilf.io.block_files import write_blocks
from ilf.io.clouds import CLOUD_SUFFIXES, write_cloud
from ilf.io.depth import DEPTH_SUFFIXES, png_losses, read_depth_values, write_depth
from ilf.io.meshes import MESH_SUFFIXES, write_mesh
from ilf.run.curves import encode_curves

RNG = np.random.default_rng(3)
DEPTH = RNG.uniform(0.4, 9.0, (20, 30)).astype(np.float32)
DEPTH[2:5, 3:9] = np.nan
LABELS = RNG.integers(0, 40_000, (20, 30)).astype(np.int32)
CLOUD = PointCloud(RNG.uniform(-3, 3, (200, 3)).astype(np.float32), RNG.integers(0, 256, (200, 3)).astype(np.uint8))
MESH = Mesh(CLOUD, RNG.integers(0, 200, (90, 3)).astype(np.int32))
HISTORY = {
    2: (
        PassBandRecord(
            i=1, stage=1, radii=(1 / 3, np.float64(0.1)), sigma_i=math.nan, l1=1e-17, residual=0.02,
            held_out=math.nan, weighted=True, seconds=0.5,
        ),
        EdgeAwareRecord(
            i=2, stage=7, cell=4, round=1, sigma_i=0.25, l1=1.5, residual=0.02, held_out=math.nan, seconds=0.6,
        ),
    ),
    1: (
        PassBandRecord(
            i=1, stage=1, radii=(2.0, 1.5), sigma_i=0.1 + 0.2, l1=7.25, residual=1 / 7, held_out=np.float64(1 / 9),
            weighted=False, seconds=1.0,
        ),
        PassBandRecord(
            i=2, stage=2, radii=(2.5, 2.0), sigma_i=np.float64(1e-3), l1=7.5, residual=0.1, held_out=0.2,
            weighted=False, seconds=2.0,
        ),
    ),
}  # fmt: skip

WRITERS = {
    **{f"depth{s}": lambda p: write_depth(p, DEPTH) for s in DEPTH_SUFFIXES},
    **{f"cloud{s}": lambda p: write_cloud(p, CLOUD) for s in CLOUD_SUFFIXES},
    **{f"mesh{s}": lambda p: write_mesh(p, MESH) for s in MESH_SUFFIXES},
    "text.ply": lambda p: write_cloud(p, CLOUD, ascii=True),
    "text.pcd": lambda p: write_cloud(p, CLOUD, ascii=True),
    "labels.png": lambda p: write_blocks(p, LABELS),
    "curves.csv": lambda p: write_bytes(p, encode_curves(HISTORY)),
}


# --- what all writers promise


@pytest.mark.parametrize("name", WRITERS)
def test_writing_twice_gives_the_same_bytes_and_leaves_nothing_else(name, tmp_path):
    first, second = tmp_path / name, tmp_path / ("größe-" + name.upper())
    WRITERS[name](first)
    WRITERS[name](second)
    WRITERS[name](first)
    assert first.read_bytes() == second.read_bytes() != b""
    assert sorted(tmp_path.iterdir()) == sorted([first, second])


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize(
    ("code", "message"),
    [
        (errno.ENOSPC, "disk is full"),
        (errno.EROFS, "read-only"),
        (errno.EIO, "I/O|nput/output"),
        (errno.EFBIG, "larger than its drive"),
        (errno.ELOOP, "symbolic links form a loop"),
        (errno.EISDIR, "Choose another name"),
        (errno.ENAMETOOLONG, "Choose a shorter one"),
    ],
)
def test_a_failure_in_the_middle_keeps_the_old_file(name, code, message, tmp_path, monkeypatch):
    target = tmp_path / name
    target.write_bytes(b"the last good result")

    def fail(_):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(ExportError, match=message) as caught:
        WRITERS[name](target)
    assert str(target) in str(caught.value)
    assert "Errno" not in str(caught.value)
    assert target.read_bytes() == b"the last good result"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", WRITERS)
def test_places_where_nothing_can_be_written(name, tmp_path):
    (tmp_path / "file").write_bytes(b"x")
    (tmp_path / name).mkdir()
    for target, message in [
        (tmp_path / "absent" / name, "no such file or folder"),
        (tmp_path / "file" / name, "no such file or folder"),
        (tmp_path / name, "Could not write"),
    ]:
        with pytest.raises(ExportError, match=message):
            WRITERS[name](target)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["file", name])


def test_a_folder_that_lets_nobody_write(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(ExportError, match=r"(?i)permission denied"):
        write_depth(tmp_path / "depth.png", DEPTH)
    assert not list(tmp_path.iterdir())


def test_errors_in_the_block_pass_through_and_leave_nothing(tmp_path):
    def write_half():
        with atomic_path(tmp_path / "x.txt") as temporary:
            assert temporary.parent == tmp_path
            assert temporary.suffix == ".txt"
            temporary.write_text("half")
            raise ParameterError("own")

    with pytest.raises(ParameterError, match="own"):
        write_half()
    assert list(tmp_path.iterdir()) == []


# --- depth


@pytest.mark.parametrize("suffix", [".tif", ".tiff", ".npy"])
def test_float_depth_comes_back_bit_for_bit(suffix, tmp_path):
    assert write_depth(tmp_path / f"d{suffix}", DEPTH) == []
    found = read_depth_values(tmp_path / f"d{suffix}")
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, DEPTH)


@pytest.mark.parametrize("units", [1000, 5000, 250.5])
def test_png_depth_is_rounded_to_the_nearest_unit(units, tmp_path):
    assert write_depth(tmp_path / "d.png", DEPTH, units) == []
    values = read_depth_values(tmp_path / "d.png")
    assert values.dtype == np.uint16
    np.testing.assert_array_equal(values == 0, np.isnan(DEPTH))
    known = ~np.isnan(DEPTH)
    assert np.abs(values[known] - DEPTH[known].astype(float) * units).max() <= 0.5


def test_clipping_is_foretold_and_told_with_the_largest_scale_that_fits(tmp_path):
    depth = np.array([[1.0, 65.5, 65.6], [70.0, np.nan, 0.0002]], np.float32)
    warnings = write_depth(tmp_path / "d.png", depth, 1000)
    assert png_losses(depth, 1000) == warnings
    np.testing.assert_array_equal(read_depth_values(tmp_path / "d.png"), [[1000, 65500, 65535], [65535, 0, 0]])
    assert len(warnings) == 2
    assert "is clipped: 2 pixels." in warnings[0]
    assert " 936 units per metre" in warnings[0]
    assert warnings[1].startswith("Depth below half a unit")
    assert not any("beyond" in text for text in write_depth(tmp_path / "d.png", depth, 936))
    assert png_losses(np.full((2, 2), np.nan, np.float32), 1000) == []


def test_missing_in_any_form_is_written_as_missing(tmp_path):
    depth = np.array([[np.nan, np.inf, -np.inf, 0.0, -2.0, 1.0]])
    write_depth(tmp_path / "d.png", depth)
    np.testing.assert_array_equal(read_depth_values(tmp_path / "d.png"), [[0, 0, 0, 0, 0, 1000]])
    write_depth(tmp_path / "d.npy", depth)
    np.testing.assert_array_equal(read_depth_values(tmp_path / "d.npy"), [[np.nan] * 5 + [1]])


@pytest.mark.parametrize("units", [0, -1, math.nan, "1000", None])
def test_depth_units_are_checked(units, tmp_path):
    with pytest.raises(ParameterError, match="units"):
        write_depth(tmp_path / "d.png", DEPTH, units)
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_an_export_is_refused(tmp_path):
    for call in (
        lambda: write_depth(tmp_path / "d.jpg", DEPTH),
        lambda: write_depth(tmp_path / "d", DEPTH),
        lambda: write_depth(tmp_path / "d.png", DEPTH[0]),
        lambda: write_blocks(tmp_path / "l.jpg", LABELS),
        lambda: write_blocks(tmp_path / "l.png", LABELS.astype(float)),
        lambda: write_blocks(tmp_path / "l.png", -LABELS),
        lambda: write_blocks(tmp_path / "l.png", LABELS + 65_535),
        lambda: write_cloud(tmp_path / "c.obj", CLOUD),
        lambda: write_cloud(tmp_path / "c.ply", PointCloud(CLOUD.points[:0], CLOUD.colours[:0])),
        lambda: write_mesh(tmp_path / "m.stl", MESH),
        lambda: write_mesh(tmp_path / "m.ply", Mesh(CLOUD, MESH.faces[:0])),
    ):
        with pytest.raises(ExportError):
            call()
    with pytest.raises(ParameterError, match="m, mm"):
        write_cloud(tmp_path / "c.ply", CLOUD, unit="inch")
    with pytest.raises(ParameterError, match="axes"):
        write_cloud(tmp_path / "c.ply", CLOUD, axes="z-up")
    with pytest.raises(ParameterError, match="axes"):
        write_mesh(tmp_path / "c.obj", MESH, axes="z-up")
    assert list(tmp_path.iterdir()) == []


# --- labels and curves


def test_curves_keep_every_digit_and_no_time(tmp_path):
    (tmp_path / "c.csv").write_bytes(encode_curves(HISTORY))
    text = (tmp_path / "c.csv").read_bytes().decode()
    columns = "label,i,stage,r_y,r_x,sigma_i_m,l1_m,residual_m,held_out_m,weighted,cell_px,round,error_m"
    assert text.splitlines()[0] == columns
    assert "\r" not in text
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [(row["label"], row["i"], row["weighted"]) for row in rows] == [
        ("1", "1", "0"),
        ("1", "2", "0"),
        ("2", "1", "1"),
        ("2", "2", ""),
    ]
    assert float(rows[0]["sigma_i_m"]) == 0.1 + 0.2
    assert float(rows[2]["r_y"]) == 1 / 3
    assert math.isnan(float(rows[2]["sigma_i_m"]))
    assert (float(rows[0]["residual_m"]), float(rows[0]["held_out_m"])) == (1 / 7, 1 / 9)
    assert (rows[2]["residual_m"], rows[2]["held_out_m"]) == ("0.02", "")
    assert [(row["r_y"] == row["r_x"] == "", row["cell_px"], row["round"]) for row in rows] == [
        (False, "", ""),
        (False, "", ""),
        (False, "", ""),
        (True, "4", "1"),
    ]


# --- clouds

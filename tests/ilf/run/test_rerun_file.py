"""A Rerun file, read by Rerun's package, which is needed only here and by those who export one."""

from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.run.rerun_file import CAMERA, ERROR

from ..small_frames import CAMERA as INTRINSICS
from ..small_frames import QUICK, write_small_frame

chunks = pytest.importorskip("rerun.chunk")

POSE = np.array([[0, 0, 1, 2], [-1, 0, 0, 3], [0, -1, 0, 4], [0, 0, 0, 1]], float)


def content(path):
    """Entity -> column -> values of its rows, flat."""
    found = {}
    for chunk in chunks.RrdReader(str(path)).stream():
        batch = chunk.to_record_batch()
        columns = found.setdefault(chunk.entity_path.removeprefix("/"), {})
        for name in batch.schema.names:
            column = batch.column(name)
            while hasattr(column, "flatten") and hasattr(column.type, "value_type"):
                column = column.flatten()
            columns[name] = column.to_pylist() if "struct" in str(column.type) else np.asarray(column)
    return found


def test_it_has_camera_images_blocks_expected_error_and_curves(tmp_path):
    frame = replace(ilf.load_frame(*write_small_frame(tmp_path / "in"), intrinsics=INTRINSICS), pose=POSE)
    completion = ilf.complete(frame, **QUICK)
    completion.export(tmp_path / "room.rrd")
    found = content(tmp_path / "room.rrd")

    for entity, kind, expected in (
        (f"{CAMERA}/depth", "DepthImage", frame.depth),
        (f"{CAMERA}/completed", "DepthImage", completion.depth),
        (ERROR, "DepthImage", ilf.expected_error(completion)),
        (f"{CAMERA}/blocks", "SegmentationImage", completion.blocks.astype(np.uint32)),
        (f"{CAMERA}/colour", "Image", frame.rgb),
    ):
        buffer = found[entity][f"{kind}:buffer"].astype(np.uint8).tobytes()
        np.testing.assert_array_equal(np.frombuffer(buffer, expected.dtype).reshape(expected.shape), expected)
    matrix = found[CAMERA]["Pinhole:image_from_camera"].reshape(3, 3).T  # by columns
    np.testing.assert_allclose(matrix, [[80, 0, 39.5], [0, 80, 29.5], [0, 0, 1]])
    np.testing.assert_array_equal(found[CAMERA]["Pinhole:resolution"], [80, 60])
    np.testing.assert_array_equal(found[CAMERA]["Transform3D:mat3x3"].reshape(3, 3).T, POSE[:3, :3])
    np.testing.assert_array_equal(found[CAMERA]["Transform3D:translation"], [2, 3, 4])

    assert len(completion.history) >= 2
    for label, history in completion.history.items():
        for curve in ("sigma_i", "l1"):
            columns = found[f"{curve}/block_{label}"]
            np.testing.assert_array_equal(columns["iteration"], [record.i for record in history])
            np.testing.assert_array_equal(columns["Scalars:scalars"], [getattr(one, curve) for one in history])


def test_a_frame_without_intrinsics_has_no_camera(tmp_path):
    frame = ilf.load_frame(*write_small_frame(tmp_path / "in"))
    ilf.complete(frame, **QUICK).export(tmp_path / "room.rrd")
    found = content(tmp_path / "room.rrd")
    assert "Pinhole:resolution" not in found[CAMERA]
    assert f"{CAMERA}/completed" in found

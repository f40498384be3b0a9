"""Numpy masked arrays: what is masked is missing, wherever an array is taken."""

import numpy as np
import pytest

import ilf
from ilf.completion.confidence.expected_error import depth_error
from ilf.data.by_hand import DepthByHand
from ilf.data.flying_points import flying_points
from ilf.data.guide import Guide
from ilf.data.neighbours import NeighbourDepth
from ilf.data.points import PointCloud
from ilf.evaluation.evaluation import evaluate
from ilf.evaluation.measuring import depth_profile, measure
from ilf.evaluation.statistics import surface_statistics
from ilf.io.block_files import write_blocks
from ilf.io.depth import encode_expected_error, read_depth_values
from ilf.io.images import encode_mask, read_labels

SHAPE = 12, 16
RGB = np.zeros((*SHAPE, 3), np.uint8)
TRUE = np.full(SHAPE, 2.0)
HIDDEN = np.zeros(SHAPE, bool)
HIDDEN[4:7, 5:9] = True
CAMERA = ilf.Camera(20.0, 22.0, 8.5, 5.5)


def masked(wrong: float = 9.0, dtype: type = np.float32) -> np.ma.MaskedArray:
    return np.ma.masked_array(np.where(HIDDEN, wrong, TRUE).astype(dtype), mask=HIDDEN)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint16])
def test_masked_depth_is_missing_in_a_frame(dtype):
    frame = ilf.RGBDFrame(RGB, masked(dtype=dtype), ground_truth=masked(dtype=dtype))
    assert np.array_equal(frame.missing, HIDDEN)
    assert np.array_equal(np.isnan(frame.ground_truth), HIDDEN)
    assert np.array_equal(np.isnan(frame.with_ground_truth(masked()).ground_truth), HIDDEN)


@pytest.mark.parametrize("dtype", [bool, np.uint8])
def test_depth_is_missing_where_an_invalid_mask_is_masked(dtype):
    invalid = np.ma.masked_array(np.zeros(SHAPE, dtype), mask=HIDDEN)
    frame = ilf.RGBDFrame(RGB, TRUE)
    assert np.array_equal(frame.with_invalid_mask(invalid).missing, HIDDEN)
    assert np.array_equal(ilf.RGBDFrame(RGB, TRUE, invalid_mask=invalid).missing, HIDDEN)


def test_colour_cannot_be_missing():
    colour = np.ma.masked_array(RGB, mask=np.broadcast_to(HIDDEN[..., None], RGB.shape))
    assert ilf.RGBDFrame(np.ma.masked_array(RGB), TRUE).rgb.shape == RGB.shape
    for use in (
        lambda: ilf.RGBDFrame(colour, TRUE),
        lambda: ilf.point_cloud(TRUE, colour, CAMERA),
        lambda: ilf.edge_strength(colour, "canny"),
    ):
        with pytest.raises(ilf.IlfError, match="masked"):
            use()


def test_masked_labels_guides_and_depth_by_hand_state_nothing():
    frame = ilf.RGBDFrame(RGB, np.where(HIDDEN, np.nan, TRUE))
    labels = np.ma.masked_array(np.ones(SHAPE, np.int32), mask=HIDDEN)
    assert np.array_equal(ilf.Run(frame, labels).blocks.labels == 0, HIDDEN)
    guide = np.ma.masked_array(np.arange(TRUE.size, dtype=float).reshape(SHAPE) + 1, mask=HIDDEN)
    for made in (Guide(guide), frame.with_guide(guide).guide, Guide.from_array(guide)):
        assert np.array_equal(np.isnan(made.values), HIDDEN)
    assert not np.isfinite(DepthByHand(np.ma.masked_array(TRUE, mask=HIDDEN)).depth[HIDDEN]).any()
    unsure = Guide(guide.data, np.ma.masked_array(np.ones(SHAPE), mask=HIDDEN))
    assert np.array_equal(unsure.confidence == 0, HIDDEN)
    layers = NeighbourDepth(np.ma.masked_array(TRUE[None].astype(np.float32), mask=HIDDEN[None]), ())
    assert np.array_equal(np.isnan(layers.layers[0]), HIDDEN)
    drawn = np.ma.masked_array(np.ones(SHAPE, bool), mask=HIDDEN)
    assert np.array_equal(~ilf.Run(frame, ilf.Blocks(np.ones(SHAPE, int), drawn=drawn)).blocks.drawn, HIDDEN)


def test_masked_pixels_are_not_written(tmp_path):
    for name in ("depth.png", "depth.npy", "depth.tif"):
        ilf.write_depth(tmp_path / name, masked())
        assert np.array_equal(np.nan_to_num(read_depth_values(tmp_path / name)) == 0, HIDDEN)
    (tmp_path / "error.npy").write_bytes(encode_expected_error("error.npy", masked())[0])
    assert np.array_equal(np.isnan(read_depth_values(tmp_path / "error.npy")), HIDDEN)
    write_blocks(tmp_path / "labels.png", np.ma.masked_array(np.full(SHAPE, 3), mask=HIDDEN))
    assert np.array_equal(read_labels(tmp_path / "labels.png") == 0, HIDDEN)
    (tmp_path / "mask.png").write_bytes(encode_mask(np.ma.masked_array(np.full(SHAPE, True), mask=HIDDEN)))
    assert np.array_equal(read_labels(tmp_path / "mask.png") == 0, HIDDEN)


def test_masked_pixels_are_not_evaluated_nor_measured():
    seen = int((~HIDDEN).sum())
    for found in (
        evaluate(masked(), TRUE, expected=masked()),
        evaluate(TRUE, masked()),
        evaluate(TRUE, TRUE, np.ma.masked_array(np.ones(SHAPE, bool), mask=HIDDEN)),
    ):
        assert (found.pixels, found.mae) == (seen, 0)
    frame = ilf.RGBDFrame(RGB, np.where(HIDDEN, np.nan, TRUE), ground_truth=TRUE)
    completion = ilf.complete(frame, np.ones(SHAPE, int))
    part = np.ma.masked_array(HIDDEN, mask=np.broadcast_to(np.arange(SHAPE[1]) < 6, SHAPE))
    assert ilf.evaluate_completion(frame, completion, part, expected=masked()).pixels == 9
    assert surface_statistics(masked()).known == seen
    assert np.isnan(depth_profile(masked(), (0.5, 5.5), (15.5, 5.5), CAMERA).depth).sum() == 4
    assert np.isnan(measure(masked(), ((6.5, 5.5), (0.5, 0.5)), CAMERA).distance)
    assert np.isnan(depth_error(frame, np.ma.masked_array(completion.depth, mask=HIDDEN))).all()


def test_masked_pixels_give_no_points():
    seen = int((~HIDDEN).sum())
    assert len(ilf.point_cloud(masked(), RGB, CAMERA)) == seen
    only = np.ma.masked_array(np.ones(SHAPE, bool), mask=HIDDEN)
    assert len(ilf.point_cloud(TRUE, RGB, CAMERA, only=only)) == seen
    for mesh in (ilf.surface_mesh(masked(), RGB, CAMERA), ilf.surface_mesh(TRUE, RGB, CAMERA, only=only)):
        assert len(mesh.vertices) == seen
    assert np.array_equal(ilf.surface_normals(masked(), CAMERA)[HIDDEN], np.tile((0, 0, -1), (HIDDEN.sum(), 1)))
    assert np.isnan(CAMERA.points(np.zeros(2), np.zeros(2), np.ma.masked_equal([9.0, 9.0], 9))).all()
    assert not flying_points(masked(), CAMERA)[HIDDEN].any()
    errors = ilf.point_cloud(TRUE, RGB, CAMERA, scalars={"expected_error": masked()}).scalars["expected_error"]
    assert (errors == 0).sum() == HIDDEN.sum()
    with pytest.raises(ilf.IlfError, match="masked"):
        PointCloud(np.ma.masked_less(np.ones((2, 3), np.float32), 2), np.zeros((2, 3), np.uint8))


def test_a_selection_does_not_start_where_it_is_masked():
    frame = ilf.RGBDFrame(RGB, TRUE)
    start = np.ma.masked_array(np.ones(SHAPE, bool), mask=True)
    assert not ilf.select_region(frame, (), start=start).any()

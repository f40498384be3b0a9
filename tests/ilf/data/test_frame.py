"""The frame: what missing means, and what is refused."""

import base64
import re

import cv2
import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest

from ilf.data.frame import RGBDFrame, scale_warning
from ilf.errors import InputError

RGB = np.zeros((2, 4, 3), np.uint8)


def test_everything_that_is_no_depth_becomes_nan():
    frame = RGBDFrame(RGB, np.array([[1.5, 0, -1, np.nan], [np.inf, -np.inf, 2, 2.5]]))
    assert frame.depth.dtype == np.float32
    assert np.array_equal(frame.known, [[True, False, False, False], [False, False, True, True]])
    assert frame.missing_share == pytest.approx(5 / 8)
    assert frame.shape == (2, 4)


def test_whole_numbers_are_taken_as_metres():
    assert RGBDFrame(RGB, np.full((2, 4), 3, np.uint16)).depth[0, 0] == 3.0


def test_arrays_are_copies_and_read_only():
    depth = np.ones((2, 4), np.float32)
    frame = RGBDFrame(RGB, depth)
    depth[0, 0] = 9
    assert frame.depth[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        frame.depth[0, 0] = 2


@pytest.mark.parametrize(
    ("rgb", "depth", "message"),
    [
        (RGB, np.ones((4, 2)), "Colour is 4 x 2, but depth is 2 x 4"),
        (RGB.astype(int), np.ones((2, 4)), "uint8"),
        (RGB + 1.5, np.ones((2, 4)), "between 0 and 1, not 1.5 and 1.5: divide it"),
        (RGB - 0.5, np.ones((2, 4)), "between 0 and 1"),
        (RGB * np.nan, np.ones((2, 4)), "between 0 and 1"),
        (RGB[..., :2], np.ones((2, 4)), "shape"),
        (RGB[0, :, 0], np.ones((2, 4)), "shape"),
        (RGB, np.ones((2, 4, 3)), "one real number per pixel"),
        (RGB, np.ones((2, 4), complex), "one real number per pixel"),
        (RGB, [[1.0, 2.0], [3.0]], "rows of equal lengths"),
        (RGB, np.zeros((2, 4)), "no known pixel"),
        (RGB, np.full((2, 4), np.nan), "no known pixel"),
        (RGB, np.full((2, 4), 1500, np.uint16), r"in metres: divide .* depth / 1000\.0 for millimetres\.$"),
        (RGB, np.full((2, 4), 0.002), "in metres: divide"),
    ],
)
def test_unusable_arrays_are_refused_with_the_way_out(rgb, depth, message):
    with pytest.raises(InputError, match=message):
        RGBDFrame(rgb, depth)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("nope", "no intrinsics preset 'nope'. Known: nyu"),
        (np.eye(4), "four numbers or a 3 x 3 matrix"),
        (object(), "plain numbers"),
    ],
)
def test_what_are_no_intrinsics_is_refused_at_once(given, message):
    with pytest.raises(InputError, match=message):
        RGBDFrame(RGB, np.ones((2, 4)), given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("metres", "units", "meant"),
    [
        (2.4, 1000, ""),
        (365.2, 1, "with 1000 units per metre it would be 0.37 m, with 100 3.65 m."),
        (12.0, 1000, "with 5000 units per metre it would be 2.40 m"),
        (0.2, 10_000, "with 1000 units"),
        (5.5, 1000, ""),
        ([7.0, 3.7], 1000, "with 5000 units per metre it would be 0.91 m"),
        (0.4, 1000, ""),
        ([0.2, 0.6], 1000, "with 256 units per metre it would be 1.95 m, with 100 5.00 m."),
        ([7.0, 3.7], 1, ""),
    ],
)
def test_unusual_scales_are_doubted_with_the_likely_one(metres, units, meant):
    text = scale_warning(np.linspace(*np.multiply([0.5, 1.5], metres), 99, dtype=np.float32), units)
    assert meant in text
    assert bool(text) == bool(meant)


def test_distrusted_depth_counts_as_missing_and_is_kept():
    rgb = np.zeros((2, 3, 3), np.uint8)
    depth = np.array([[1, 2, 0], [1, 1, 2]], np.float32)
    mask = np.array([[False, True, True], [False, False, False]])
    frame = RGBDFrame(rgb=rgb, depth=depth, invalid_mask=mask)
    assert np.array_equal(frame.known, [[True, False, False], [True, True, True]])
    assert np.array_equal(frame.measured, [[1, 2, np.nan], [1, 1, 2]], equal_nan=True)
    other = frame.with_invalid_mask(~mask & (depth == 2))
    assert np.array_equal(other.known, [[True, True, False], [True, True, False]])
    assert np.array_equal(other.measured, frame.measured, equal_nan=True)
    trusted = other.with_invalid_mask(None)
    assert trusted.invalid_mask is None
    assert np.array_equal(trusted.depth, frame.measured, equal_nan=True)
    assert trusted.with_invalid_mask(np.zeros((2, 3), bool)) is trusted
    with pytest.raises(ValueError):
        frame.invalid_mask[0, 0] = True


@pytest.mark.parametrize("mask", [np.ones((3, 2), bool), np.full((2, 3), 2), np.full((2, 3), 0.5)])
def test_a_mask_that_does_not_fit_is_refused(mask):
    with pytest.raises(InputError, match="bool with the frame's shape"):
        RGBDFrame(rgb=np.zeros((2, 3, 3), np.uint8), depth=np.ones((2, 3)), invalid_mask=mask)


def test_colour_that_nobody_can_write_to_is_shared_and_any_other_copied():
    rgb, depth = np.zeros((2, 3, 3), np.uint8), np.ones((2, 3))
    frame = RGBDFrame(rgb, depth)
    view = rgb[:]
    view.flags.writeable = False
    for colour in (rgb, view):
        assert not np.shares_memory(RGBDFrame(colour, depth).rgb, rgb)
    assert RGBDFrame(frame.rgb, depth).rgb is frame.rgb
    assert frame.with_invalid_mask([[True, False, False]] * 2).rgb is frame.rgb


def test_a_truth_is_kept_in_metres_and_by_what_is_made_of_the_frame(small_frame):
    ground_truth = np.full(small_frame.shape, 2.0)
    ground_truth[0, :3] = [0.0, -1.0, np.inf]
    frame = small_frame.with_ground_truth(ground_truth)
    assert frame.ground_truth.dtype == np.float32
    assert np.isnan(frame.ground_truth[0, :3]).all()
    assert not frame.ground_truth.flags.writeable
    wrong = np.zeros(frame.shape, bool)
    wrong[0, 5] = True
    np.testing.assert_array_equal(frame.with_invalid_mask(wrong).ground_truth, frame.ground_truth)
    np.testing.assert_array_equal(
        frame.with_invalid_mask(wrong).with_ground_truth(None).depth, frame.with_invalid_mask(wrong).depth
    )
    assert frame.with_ground_truth(None).ground_truth is None


@pytest.mark.parametrize(
    ("ground_truth", "why"),
    [
        (np.ones((4, 4)), "The ground truth is 4 x 4, but the frame is 64 x 48"),
        (np.zeros((48, 64)), "The ground truth has no known pixel"),
        (np.ones((48, 64, 3)), "The ground truth cannot be used"),
        (np.full((48, 64), 1500), "divide it, such as depth / 1000"),
    ],
)
def test_a_truth_that_does_not_fit_is_refused(small_frame, ground_truth, why):
    with pytest.raises(InputError, match=why):
        small_frame.with_ground_truth(ground_truth)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_colour_from_0_to_1_and_grey_are_converted(kind):
    rgb = np.array([[[0, 0.5, 1]]], kind)
    assert RGBDFrame(rgb, [[1.0]]).rgb.tolist() == [[[0, 128, 255]]]
    for grey in (np.array([[7, 200]], np.uint8), np.array([[[7], [200]]], np.uint8)):
        frame = RGBDFrame(grey, [[1.0, 2.0]])
        assert (frame.rgb.dtype, frame.rgb.tolist()) == (np.uint8, [[[7, 7, 7], [200, 200, 200]]])


@pytest.mark.parametrize("one", [1, 255, True])
def test_masks_of_0_and_1_or_255_are_taken(one):
    mask = one * np.array([[1, 0, 0, 1], [0, 0, 0, 0]], bool if one is True else np.uint8)
    frame = RGBDFrame(RGB, np.ones((2, 4)), invalid_mask=mask)
    assert frame.invalid_mask.dtype == np.bool_
    np.testing.assert_array_equal(frame.known, mask == 0)


def test_a_frame_is_a_line_of_text_and_pictures_in_a_notebook():
    frame = RGBDFrame(RGB + np.uint8(9), [[1.5, 2, np.nan, 2], [1, 2, 2, 2]], name="a <room>")
    assert repr(frame) == "<RGBDFrame 'a <room>': 4 x 2 pixels, depth 1 to 2 m, 12.5% missing>"
    html = frame._repr_html_()
    assert "a &lt;room&gt;" in html
    pictures = [
        cv2.imdecode(np.frombuffer(base64.b64decode(png), np.uint8), cv2.IMREAD_COLOR_RGB)
        for png in re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    ]
    np.testing.assert_array_equal(pictures[0], frame.rgb)
    assert pictures[1].shape == frame.rgb.shape
    assert pictures[1][0, 2].tolist() == [178, 182, 189], "missing"
    assert pictures[1][0, 1].tolist() == pictures[1][1, 3].tolist() != pictures[1][1, 0].tolist()


def test_a_frame_is_plotted():
    matplotlib.use("agg")
    colour, depth = RGBDFrame(RGB, np.ones((2, 4))).plot()
    assert (colour.get_title(), depth.get_title()) == ("Colour", "Depth")
    assert colour.figure.axes[-1].get_ylabel() == "Depth [m]"
    depth.figure.canvas.draw()
    matplotlib.pyplot.close(depth.figure)

"""Registration of raw pairs: exact depth of a wall with a board before it says what is right."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ilf import Camera
from ilf.errors import InputError
from ilf.sources.registration import RawPair, register

from ..two_cameras import COLOUR, DEPTH, made_pair, motion, rays, seen

PLAIN = replace(COLOUR, distortion=())


def exact(frame):
    height, width = frame.shape
    view = replace(frame.intrinsics, size=(width, height))
    return rays(view), seen(rays(view), np.eye(4)).reshape(frame.shape)


def places(points, pair):
    """Where points of the colour camera lie in the depth image, (N, 2)."""
    back = np.linalg.inv(pair.depth_to_colour)
    own = points @ back[:3, :3].T + back[:3, 3]
    camera = pair.depth_camera
    found, _ = cv2.projectPoints(own, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    return found[:, 0]


def seen_by_depth(points, pair):
    """Whether the depth camera sees points of the colour camera: in its image, and behind nothing."""
    back = np.linalg.inv(pair.depth_to_colour)
    own = points @ back[:3, :3].T + back[:3, 3]
    first = seen(own / own[:, 2:], pair.depth_to_colour)
    return inside(places(points, pair), pair.depth_camera) & (np.abs(first - own[:, 2]) < 1e-3)


def inside(where, camera):
    return ((where >= -0.5) & (where < np.array(camera.size) - 0.5)).all(axis=1)


def steep(depth):
    """Pixels with something much nearer or farther beside them."""
    found = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        jump = np.abs(np.diff(depth, axis=axis)) > 0.3
        first, second = [slice(None)] * 2, [slice(None)] * 2
        first[axis], second[axis] = slice(None, -1), slice(1, None)
        found[tuple(first)] |= jump
        found[tuple(second)] |= jump
    return found


@pytest.mark.parametrize("colour", [COLOUR, PLAIN], ids=["bent", "straight"])
@pytest.mark.parametrize("depth", [DEPTH, replace(DEPTH, distortion=())], ids=["bent", "straight"])
def test_depth_comes_to_the_pixels_that_show_it(colour, depth):
    pair = made_pair(colour, depth)
    frame = register(pair)
    views, ground_truth = exact(frame)
    off = np.abs(frame.depth - ground_truth)
    near_edge = steep(ground_truth) | steep(np.roll(ground_truth, 2, 1)) | steep(np.roll(ground_truth, -2, 1))
    evaluated = frame.known & ~near_edge
    # a depth pixel is 4 cm wide on the wall, which leans back by a tenth
    assert evaluated.mean() > 0.6
    assert off[evaluated].max() < 0.01
    visible = seen_by_depth(views * ground_truth.reshape(-1, 1), pair).reshape(frame.shape)
    assert frame.known[visible].mean() > 0.995, "no false holes"


def test_what_lies_outside_the_depth_image_is_marked():
    pair = made_pair()
    frame = register(pair)
    views, ground_truth = exact(frame)
    assert frame.outside_view is not None
    assert not frame.known[frame.outside_view].any()
    nearest, farthest = np.quantile(frame.depth[frame.known], (0.01, 0.99))
    reached = np.zeros(frame.shape, bool)
    for depth in 1 / np.linspace(1 / nearest, 1 / farthest, 16):
        reached |= inside(places(views * depth, pair), pair.depth_camera).reshape(frame.shape)
    assert (frame.outside_view == ~reached & ~frame.known).mean() > 0.99, "samples and pixels differ along the border"
    beyond = ~inside(places(views * ground_truth.reshape(-1, 1), pair), pair.depth_camera).reshape(frame.shape)
    assert frame.outside_view[beyond].mean() > 0.7, "others would be seen at other depths that the frame has"


def test_colour_has_no_invented_pixels_and_its_intrinsics_fit():
    frame = register(made_pair())
    assert frame.intrinsics.fx > COLOUR.fx, "what the lens cut off at the corners is cut off everywhere"
    # colour says how far to the right of the bent image a pixel comes from
    views, _ = exact(frame)
    source, _ = cv2.projectPoints(views, np.zeros(3), np.zeros(3), COLOUR.matrix, COLOUR.coefficients)
    columns = source[:, 0, 0].reshape(frame.shape)
    assert columns.min() > -0.01
    assert columns.max() < COLOUR.size[0] - 0.99
    assert np.abs(frame.rgb[..., 0] - 255 * columns / COLOUR.size[0]).max() < 3


def test_colour_without_distortion_stays_as_it_is():
    pair = made_pair(PLAIN)
    frame = register(pair)
    assert frame.rgb is pair.rgb
    assert frame.intrinsics == PLAIN.pinhole
    assert frame.name == "board"


@settings(max_examples=10, deadline=None)
@given(scale=st.floats(0.4, 3.0), x=st.floats(-0.1, 0.1), turn=st.floats(-0.1, 0.1), k1=st.floats(-0.15, 0.15))
def test_a_closed_wall_stays_closed_whatever_the_cameras(scale, x, turn, k1):
    fine, size = (40 * scale, 40 * scale, 20 * scale, 15 * scale), (round(40 * scale), round(30 * scale))
    colour = Camera(*fine, size=size, distortion=(k1, 0.0, 0.0, 0.0))
    depth = Camera(40.0, 42.0, 19.1, 15.2, size=(40, 30), distortion=(-k1, 0.01, 0.0, 0.0))
    to_colour = motion(x, turn)
    frame = register(RawPair(np.zeros((*colour.shape, 3), np.uint8), np.full((30, 40), 2.0), colour, depth, to_colour))
    outside = np.zeros(frame.shape, np.uint8) if frame.outside_view is None else frame.outside_view.astype(np.uint8)
    at_rim = cv2.dilate(np.pad(outside, 1, constant_values=1), np.ones((3, 3), np.uint8))[1:-1, 1:-1] > 0
    assert not (frame.missing & ~at_rim).any(), "what is in view has depth, but for single pixels at its rim"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"depth": np.full((4, 5), 2.0)}, "5 x 4"),
        ({"rgb": np.zeros((4, 5, 3), np.uint8)}, "Colour is 5 x 4"),
        ({"depth_to_colour": np.diag([2.0, 2.0, 2.0, 1.0])}, "without scale or reflection"),
        ({"depth_to_colour": np.diag([-1.0, 1.0, 1.0, 1.0])}, "without scale or reflection"),
        ({"depth_to_colour": np.eye(3)}, "4 x 4"),
        ({"depth_to_colour": np.full((4, 4), np.nan)}, "finite"),
        ({"depth_view": np.ones((3, 3), bool)}, "depth camera's view"),
    ],
)
def test_pairs_that_make_no_sense_are_refused(change, message):
    pair = made_pair()
    values = {
        "rgb": pair.rgb,
        "depth": pair.depth,
        "colour_camera": COLOUR,
        "depth_camera": DEPTH,
        "depth_to_colour": pair.depth_to_colour,
    }
    with pytest.raises(InputError, match=message):
        RawPair(**(values | change))


def test_pairs_that_cannot_be_registered_are_told_why():
    pair = made_pair()
    nothing = RawPair(pair.rgb, np.zeros(DEPTH.shape), COLOUR, DEPTH, np.eye(4))
    with pytest.raises(InputError, match="no known pixel"):
        register(nothing)
    away = np.eye(4)
    away[:3, 3] = 0.0, 0.0, -50.0
    with pytest.raises(InputError, match="No depth falls into the colour image"):
        register(RawPair(pair.rgb, pair.depth, COLOUR, DEPTH, away))
    bent = replace(COLOUR, distortion=(-3.0, 0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="cannot be inverted"):
        register(RawPair(pair.rgb, pair.depth, bent, DEPTH, np.eye(4)))


@pytest.mark.parametrize(
    ("distortion", "why"),
    [
        ((1.0, 2.0, 3.0), "must have 0, 4, 5, 8, 12 or 14 coefficients"),
        ((np.nan, 0.0, 0.0, 0.0), "must be finite"),
        ((1e9, 0.0, 0.0, 0.0), "must be finite"),
    ],
)
def test_distortions_that_are_none_are_refused(distortion, why):
    with pytest.raises(InputError, match=f"distortion {why}"):
        replace(COLOUR, distortion=distortion)


@pytest.mark.filterwarnings("ignore::ilf.errors.DepthWarning")  # of focal lengths that are hardly possible
@settings(max_examples=8, deadline=None)
@given(k=st.lists(st.floats(-100, 100), min_size=8, max_size=8), focal=st.floats(1.0, 1000.0), is_colour=st.booleans())
def test_whatever_the_distortion_there_is_a_frame_or_a_word(k, focal, is_colour):
    bent = Camera(focal, focal, 16.0, 12.0, distortion=tuple(k))
    plain = Camera(30.0, 31.0, 15.1, 12.2)
    colour, depth = (bent, plain) if is_colour else (plain, bent)
    pair = RawPair(np.zeros((24, 32, 3), np.uint8), np.full((24, 32), 2.0), colour, depth, motion())
    try:
        frame = register(pair)
    except InputError:
        return
    assert frame.known.any()
    assert frame.depth[frame.known].min() > 0

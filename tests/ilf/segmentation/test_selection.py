"""Selecting a surface or object by points: properties, and a box on a floor that anyone would select as one."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ilf
from ilf.errors import InputError
from ilf.segmentation.region_tree import region_tree

HEIGHT, WIDTH = 48, 64
OBJECT = np.zeros((HEIGHT, WIDTH), bool)
OBJECT[14:36, 19:46] = True
POINTS = st.tuples(st.floats(0, WIDTH - 0.01), st.floats(0, HEIGHT - 0.01))


def box_on_floor():
    """A red box, half a metre above a grey floor, with noise in its colour."""
    rng = np.random.default_rng(0)
    colour = np.where(OBJECT[..., None], (200, 40, 30), (120, 125, 130)) + rng.normal(0, 3, (HEIGHT, WIDTH, 3))
    depth = np.where(OBJECT, 1.0, 1.5).astype(np.float32)
    depth[22:28, 25:30] = np.nan
    return ilf.RGBDFrame(rgb=np.clip(colour, 0, 255).astype(np.uint8), depth=depth)


FRAME = box_on_floor()


def share(mask, other):
    return np.count_nonzero(mask & other) / np.count_nonzero(mask | other)


@pytest.mark.parametrize(
    ("inside", "expected"), [((32, 25), OBJECT), ((27, 25), OBJECT), ((5, 5), ~OBJECT)], ids=("box", "hole", "floor")
)
def test_a_click_selects_the_surface_under_it(inside, expected):
    assert share(ilf.select_region(FRAME, [inside]), expected) > 0.9


def test_a_box_around_an_object_selects_it():
    assert share(ilf.select_region(FRAME, [], box=(18, 13, 47, 37)), OBJECT) > 0.9
    assert not ilf.select_region(FRAME, [(5, 5)], box=(0, 0, 15, 15))[25, 32]


def test_a_point_outside_takes_its_region_away():
    assert ilf.select_region(FRAME, [(5, 5)], steps=20).all()
    assert share(ilf.select_region(FRAME, [(5, 5)], [(32, 25)], steps=20), ~OBJECT) > 0.9


def test_points_change_a_selection_to_start_with():
    start = np.zeros((HEIGHT, WIDTH), bool)
    start[:, 20:] = True
    taken = ilf.select_region(FRAME, [], [(32, 25)], start=start)
    assert not taken[15:35, 21:45].any()
    assert taken[:, 50:].all()
    assert not taken[:, :18].any()
    added = ilf.select_region(FRAME, [(32, 25)], start=taken)
    assert added[15:35, 21:45].all()
    assert np.array_equal(added[:, 50:], start[:, 50:])
    assert np.array_equal(ilf.select_region(FRAME, [], start=start), start)


@settings(deadline=None, max_examples=12)
@given(st.lists(POINTS, min_size=1, max_size=4), st.lists(POINTS, max_size=3), st.integers(-3, 3))
def test_points_inside_are_selected_and_points_outside_are_not(inside, outside, steps):
    mask = ilf.select_region(FRAME, inside, outside, steps=steps)
    pieces = region_tree(FRAME).pieces
    wanted = {pieces[int(y), int(x)] for x, y in inside}
    assert mask.dtype == bool
    assert mask.shape == FRAME.shape
    assert all(mask[int(y), int(x)] for x, y in inside)
    assert not any(mask[int(y), int(x)] for x, y in outside if pieces[int(y), int(x)] not in wanted)


@settings(deadline=None, max_examples=5)
@given(POINTS)
def test_steps_go_from_part_to_object(point):
    masks = [ilf.select_region(FRAME, [point], steps=steps) for steps in range(-2, 4)]
    for smaller, larger in pairwise(masks):
        assert not (smaller & ~larger).any()


PRINTED = np.zeros_like(OBJECT)
PRINTED[20:30, 28:38] = True


def test_a_click_on_print_selects_the_object_and_a_step_back_the_print():
    colour = FRAME.rgb.copy()
    colour[PRINTED] = (235, 235, 230)
    frame = ilf.RGBDFrame(rgb=colour, depth=FRAME.depth)
    assert share(ilf.select_region(frame, [(32, 25)]), OBJECT) > 0.9
    smaller = [ilf.select_region(frame, [(32, 25)], steps=-steps) for steps in range(1, 20)]
    assert max(share(mask, PRINTED) for mask in smaller) > 0.8, "10 pixels wide"


def test_a_hierarchy_divides_the_frame_and_every_node_is_its_two_parts():
    tree = region_tree(FRAME)
    count = tree.order.size
    assert sorted(tree.order.tolist()) == list(range(count)) == np.unique(tree.pieces).tolist()
    assert tree.pixels[-1] == FRAME.depth.size
    assert (tree.parents[:-1] > np.arange(2 * count - 2)).all()
    for node in range(count, 2 * count - 1):
        parts = [set(np.flatnonzero(mask)) for mask in tree.masks(np.flatnonzero(tree.parents == node).tolist())]
        assert len(parts) == 2
        assert not parts[0] & parts[1]
        assert parts[0] | parts[1] == set(np.flatnonzero(tree.masks([node])[0]))


@pytest.mark.parametrize(
    ("inside", "outside", "box"),
    [
        ([], [], None),
        ([(WIDTH, 3)], [], None),
        ([(3, 3)], [(3, -1)], None),
        ([(3, 3)], [], (100, 0, 150, 20)),
        ([(float("nan"), 3)], [], None),
        ([[(3, 3)], []], [], None),
    ],
)
def test_impossible_points_are_refused(inside, outside, box):
    with pytest.raises(InputError):
        ilf.select_region(FRAME, inside, outside, box)
    with pytest.raises(InputError, match="but the frame is"):
        ilf.select_region(FRAME, [(3, 3)], start=np.zeros((4, 4), bool))


def test_every_point_inside_may_have_its_own_steps():
    first, second = (32, 25), (5, 5)
    part = ilf.select_region(FRAME, [first], steps=-2)
    both = ilf.select_region(FRAME, [first, second], steps=[-2, -30])
    assert (both & part == part).all()
    assert np.count_nonzero(both) < 2 * np.count_nonzero(part)
    with pytest.raises(InputError, match="2 points"):
        ilf.select_region(FRAME, [first, second], steps=[1])

"""Known depth that is suggested to be distrusted: what gives itself away, and nothing else."""

import numpy as np

from ilf.data.frame import RGBDFrame
from ilf.evaluation.quality.invalid_depth import suggest_invalid

HEIGHT, WIDTH = 120, 160
THING = np.s_[40:70, 60:80]


def wall() -> np.ndarray:
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return 1 / (0.5 + 0.0005 * columns - 0.0003 * rows)


def suggested(depth: np.ndarray, rgb: np.ndarray | None = None, edge: np.ndarray | None = None) -> np.ndarray:
    colours = np.full((HEIGHT, WIDTH, 3), 120, np.uint8) if rgb is None else rgb
    strength = np.zeros((HEIGHT, WIDTH), np.float32) if edge is None else edge
    return suggest_invalid(RGBDFrame(colours, depth), strength)


def contour() -> np.ndarray:
    edge = np.zeros((HEIGHT, WIDTH), np.float32)
    edge[THING] = 0.8
    edge[42:68, 62:78] = 0
    return edge


def through_glass() -> np.ndarray:
    depth = wall()
    depth[50:60, 65:75] = np.nan
    return depth


def test_flying_pixels_and_speckles():
    depth = wall()
    depth[20, 30] = 0.9
    depth[100:102, 50:52] -= 0.5
    wrong = np.zeros((HEIGHT, WIDTH), bool)
    wrong[20, 30] = wrong[100:102, 50:52] = True
    assert np.array_equal(suggested(depth), wrong)


def test_small_pieces_on_the_surface_beside_them_are_trusted():
    depth = wall()
    piece = depth[60:62, 80:82].copy()
    depth[55:67, 75:87] = np.nan
    depth[60:62, 80:82] = piece
    assert not suggested(depth).any()


def test_a_pole_is_no_speckle():
    depth = wall()
    depth[:, 70:74] = 1.0
    assert not suggested(depth).any()


def test_depth_that_runs_on_through_a_thing_of_glass():
    depth = through_glass()
    found = suggested(depth, edge=contour())
    inside = np.zeros_like(found)
    inside[THING] = True
    assert np.array_equal(found, inside & np.isfinite(depth))


def test_a_print_on_the_wall_is_no_glass():
    assert not suggested(wall(), edge=contour()).any()  # no depth is missing
    rgb = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    rgb[THING] = [220, 30, 30]
    assert not suggested(through_glass(), rgb, contour()).any()  # not seen through


def test_a_thing_in_front_is_no_glass():
    depth = through_glass()
    depth[THING] -= 0.3
    assert not suggested(depth, edge=contour()).any()


def test_what_the_rim_cuts_off_is_not_judged():
    depth, edge = through_glass(), contour()
    assert not suggested(np.roll(depth, -40, axis=0), edge=np.roll(edge, -40, axis=0)).any()

"""The bench of blocks: every measure where its value is known, and the methods."""

import dataclasses

import numpy as np
import pytest

import ilf
from ilf.data.pixel_grids import mark

from .blocks.measures import find_reference, score_blocks

SHAPE = (80, 120)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
STEP = np.where(COLUMNS < 60, 1.0, 1.5)
"""Two walls, one behind the other, that meet between columns 59 and 60."""

HALVES = np.where(COLUMNS < 60, 1, 2).astype(np.int32)
WHOLE = np.ones(SHAPE, np.int32)


def evidence_of(depth, missing=False):
    return find_reference(ilf.RGBDFrame(np.full((*SHAPE, 3), 100, np.uint8), np.where(missing, np.nan, depth)))


def measure(name, labels, evidence):
    return score_blocks(np.asarray(labels, np.int32), evidence)[name]


def with_jump(rows):
    """Evidence of nothing but a jump between columns 59 and 60, in some rows."""
    found = evidence_of(np.full(SHAPE, 1.0))
    return dataclasses.replace(found, jumps=(((COLUMNS == 59) & rows)[:, :-1], found.jumps[1]))


def test_a_jump_stands_where_depth_steps_and_nowhere_else():
    np.testing.assert_array_equal(mark(evidence_of(STEP).jumps), COLUMNS == 59)
    flying = np.full(SHAPE, 1.0)
    flying[20:70:9, 15:110:11] = 3.0
    for depth in (np.where(COLUMNS < 60, 1.0, 1.03), np.where(COLUMNS < 60, 4.0, 4.1), flying):
        assert not mark(evidence_of(depth).jumps).any()
    for width, seen in ((6, True), (20, False)):
        assert mark(evidence_of(STEP, abs(COLUMNS - 59.5) < width / 2).jumps).any() == seen


def test_smooth_is_the_inside_of_a_noisy_wall_and_not_its_corner():
    noise = np.random.default_rng(0).normal(0, 0.006, SHAPE)
    inside = np.s_[13:-13, 13:-13]
    slanted = 2.0 / (1 + 0.8 * (COLUMNS - 60) / 525 + 0.5 * ROWS / 525)
    assert mark(evidence_of(slanted + noise).smooth)[inside].mean() > 0.95
    corner = mark(evidence_of(2.0 / (1 + abs(COLUMNS - 60) / 525) + noise).smooth)  # two walls at a right angle
    assert not corner[:, 58:62].any()
    assert corner[20:60, 20:45].all()


def test_coverage_is_inside_the_margins_and_of_the_frame():
    colour = np.full((*SHAPE, 3), 100, np.uint8)
    colour[:4] = colour[-4:] = colour[:, :6] = colour[:, -6:] = 255
    labels = np.zeros(SHAPE, np.int32)
    labels[4:-4, 6:60] = 1
    score = score_blocks(labels, find_reference(ilf.RGBDFrame(colour, STEP)))
    assert (score["coverage"], score["frame_coverage"]) == (0.5, pytest.approx(54 * 72 / labels.size))
    assert score["blocks"] == 1


def test_missing_pixels_are_recoverable_in_blocks_with_enough_depth():
    evidence = evidence_of(STEP, COLUMNS >= 30)
    assert measure("recoverable", HALVES, evidence) == pytest.approx(30 / 90)
    assert measure("recoverable", WHOLE, evidence) == 1.0
    assert measure("recoverable", np.where(COLUMNS < 45, 1, 0), evidence) == pytest.approx(15 / 90)
    assert measure("recoverable", WHOLE, evidence_of(STEP)) is None


@pytest.mark.parametrize(
    ("corner", "leaks"),
    [
        ([[1, 1, 2], [1, 2, 2], [3, 3, 2]], 0),
        ([[1, 0, 2], [0, 2, 2], [2, 2, 0]], 0),
        ([[1, 2, 2], [2, 1, 1], [2, 1, 1]], 2),
        ([[1, 2, 1], [1, 2, 1], [3, 2, 3]], 2),
    ],
)
def test_a_leak_is_a_block_in_pieces(corner, leaks):
    labels = np.zeros(SHAPE, np.int32)
    labels[:3, :3] = corner
    assert measure("leaks", labels, evidence_of(STEP)) == leaks


def test_purity_is_the_area_of_blocks_without_a_jump():
    evidence, third = evidence_of(STEP), np.where(COLUMNS < 40, 1, 2)
    assert measure("purity", HALVES, evidence) == 1.0
    assert measure("purity", WHOLE, evidence) == 0.0
    assert measure("purity", third, evidence) == pytest.approx(1 / 3)
    assert measure("purity", third, evidence_of(STEP, COLUMNS < 40)) == 0.0
    assert measure("purity", np.zeros(SHAPE), evidence) is None
    assert measure("purity", WHOLE, with_jump(ROWS % 8 < 6)) == 1.0


@pytest.mark.parametrize(("slots", "longest"), [(0, 10), (40, 24)])
def test_jumps_count_from_a_length_and_a_share_of_the_perimeter(slots, longest):
    """A comb: 40 slots of 25 px in a block of 80 x 120 px, which itself has 400 px of outline."""
    comb = WHOLE.copy()
    comb[50:75, 10 : 10 + 2 * slots : 2] = 0
    assert longest <= max(10, 0.01 * (400 + slots * 2 * (25 + 1))) < longest + 1
    assert measure("purity", comb, with_jump(longest > ROWS)) == 1.0
    assert measure("purity", comb, with_jump(longest + 1 > ROWS)) == 0.0


def test_cut_rate_counts_the_smooth_pairs_that_are_parted():
    evidence = evidence_of(STEP)
    right, below = evidence.smooth
    assert measure("cut_rate", HALVES, evidence) == 0.0
    quarters = np.where(COLUMNS < 90, HALVES, 3)
    assert measure("cut_rate", quarters, evidence) == pytest.approx(right[:, 89].sum() / (right.sum() + below.sum()))
    assert measure("cut_rate", np.arange(HALVES.size).reshape(SHAPE) + 1, evidence) == 1.0
    assert measure("cut_rate", HALVES, evidence_of(STEP, (ROWS + COLUMNS) % 2 == 0)) is None


def cut_at(*columns):
    return np.searchsorted(columns, COLUMNS, side="right") + 1


HOLE = (COLUMNS > 80) & (COLUMNS < 110)


@pytest.mark.parametrize(
    ("labels", "missing", "recall", "precision", "f"),
    [
        (cut_at(60), False, 1.0, 1.0, 1.0),
        (cut_at(62), False, 1.0, 1.0, 1.0),
        (cut_at(63), False, 0.0, 0.0, 0.0),
        (cut_at(60, 90), False, 1.0, 0.5, 2 / 3),
        (np.where(ROWS < 40, HALVES, 1), False, 42 / 80, 42 / 100, 7 / 15),
        (WHOLE, False, 0.0, None, 0.0),
        (cut_at(60, 95), HOLE, 1.0, 1.0, 1.0),  # boundaries in holes are not evaluated
        (HALVES, COLUMNS > 55, None, None, None),  # nor are any where depth has no jump
    ],
)
def test_boundaries_are_held_against_jumps_with_two_pixels_to_spare(labels, missing, recall, precision, f):
    score = score_blocks(labels.astype(np.int32), evidence_of(STEP, missing))
    assert [score["recall"], score["precision"], score["f"]] == [
        None if value is None else pytest.approx(value) for value in (recall, precision, f)
    ]

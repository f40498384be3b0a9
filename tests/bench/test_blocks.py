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


def in_pieces(corner):
    labels = np.zeros(SHAPE, np.int32)
    labels[:3, :3] = corner
    return labels


THIRD, MISSING = np.where(COLUMNS < 40, 1, 2), COLUMNS >= 30


@pytest.mark.parametrize(
    ("name", "labels", "missing", "value"),
    [
        ("coverage", COLUMNS < 60, False, 0.5),
        ("recoverable", HALVES, MISSING, 30 / 90),
        ("recoverable", WHOLE, MISSING, 1.0),
        ("recoverable", COLUMNS < 45, MISSING, 15 / 90),
        ("recoverable", WHOLE, False, None),
        ("leaks", in_pieces([[1, 1, 2], [1, 2, 2], [3, 3, 2]]), False, 0),
        ("leaks", in_pieces([[1, 2, 2], [2, 1, 1], [2, 1, 1]]), False, 2),
        ("purity", HALVES, False, 1.0),
        ("purity", WHOLE, False, 0.0),
        ("purity", THIRD, False, 1 / 3),
        ("purity", THIRD, COLUMNS < 40, 0.0),
        ("purity", np.zeros(SHAPE), False, None),
        ("cut_rate", HALVES, False, 0.0),
        ("cut_rate", np.arange(HALVES.size).reshape(SHAPE) + 1, False, 1.0),
        ("cut_rate", HALVES, (ROWS + COLUMNS) % 2 == 0, None),
    ],
)
def test_measures_of_two_walls(name, labels, missing, value):
    assert measure(name, labels, evidence_of(STEP, missing)) == (value if value is None else pytest.approx(value))


@pytest.mark.parametrize(("slots", "longest"), [(0, 10), (40, 24)])
def test_jumps_count_from_a_length_and_a_share_of_the_perimeter(slots, longest):
    """A comb: 40 slots of 25 px in a block of 80 x 120 px, which itself has 400 px of outline."""
    comb = WHOLE.copy()
    comb[50:75, 10 : 10 + 2 * slots : 2] = 0
    assert measure("purity", comb, with_jump(longest > ROWS)) == 1.0
    assert measure("purity", comb, with_jump(longest + 1 > ROWS)) == 0.0


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

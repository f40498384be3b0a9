"""What the twelve corrections want, and the hand that draws them; the walk itself is a bench."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from ilf import extract_blocks
from tests.bench.corrections import brush
from tests.bench.corrections.hand import TREMOR, Stroke, by_hand, stroke
from tests.bench.corrections.scenes import frames_folder, load_scene, their_network
from tests.bench.corrections.targets import Correction, Piece, inside, read_corrections, target_map, wrong_pixels

_RIGHT_EDGE = Piece(((25, 0), (30, 0), (30, 20), (25, 20)), ((20, 5),), taker=(35, 5))
_ISLAND = Piece(((32, 12), (38, 12), (38, 18), (32, 18)), ((35, 5),), seed=(35, 15))


@pytest.fixture
def labels() -> np.ndarray:
    """20 x 40: block 2 left of column 30, block 1 right of it, and a rim of no block above."""
    labels = np.full((20, 40), 2, np.int32)
    labels[:, 30:] = 1
    labels[0] = 0
    return labels


def _correction(*pieces: Piece) -> Correction:
    return Correction("test", "none", "", (20, 0, 40, 20), pieces)


def test_a_pixel_lies_in_a_polygon_if_its_centre_does() -> None:
    found = inside((4, 6), ((1.4, 1), (4.6, 1), (4.4, 3), (1.6, 3)))
    assert np.array_equal(np.argwhere(found), [[1, 1], [1, 2], [1, 3], [1, 4], [2, 2], [2, 3]])


def test_only_givers_give_and_own_blocks_get_new_numbers(labels: np.ndarray) -> None:
    target = target_map(labels, _correction(_RIGHT_EDGE, _ISLAND))
    assert (target[1:, 25:30] == 1).all()
    assert (target[0] == 0).all(), "no block gives nothing"
    assert (target[12:18, 32:38] == 3).all()
    assert np.count_nonzero(target != labels) == 19 * 5 + 36


def test_a_target_without_a_block_to_give_or_take_is_refused(labels: np.ndarray) -> None:
    with pytest.raises(ValueError, match="no block at"):
        target_map(labels, _correction(Piece(_RIGHT_EDGE.polygon, ((20, 0),), (35, 5))))
    with pytest.raises(ValueError, match="no pixel"):
        target_map(labels, _correction(Piece(_ISLAND.polygon, ((20, 5),), (35, 5))))


def test_blocks_may_have_other_numbers_than_the_target_has(labels: np.ndarray) -> None:
    correction = _correction(_RIGHT_EDGE, _ISLAND)
    target = target_map(labels, correction)
    names = np.array([0, 3, 7, 1], np.int32)
    assert not wrong_pixels(names[target], target, correction).any()
    moved = names[target]
    moved[4, 24] = moved[4, 25]
    moved[4, 2] = moved[4, 25]
    assert np.array_equal(np.argwhere(wrong_pixels(moved, target, correction)), [[4, 24]]), "only in the region"


def test_what_is_not_parted_is_wrong_once(labels: np.ndarray) -> None:
    correction = _correction(_ISLAND)
    target = target_map(labels, correction)
    assert np.array_equal(wrong_pixels(labels, target, correction), target == 3)


def test_a_hand_trembles_a_little_and_the_same_way_again() -> None:
    path = [(10.0, 20.0), (90.0, 20.0)]
    drawn = np.array(by_hand(path, "some stroke"))
    assert np.array_equal(drawn, by_hand(path, "some stroke"))
    assert not np.array_equal(drawn, by_hand(path, "another"))
    off = drawn - np.column_stack([np.linspace(10, 90, len(drawn)), np.full(len(drawn), 20.0)])
    assert TREMOR / 4 < np.abs(off).max() <= TREMOR
    assert np.abs(np.diff(off, axis=0)).max() < TREMOR / 2, "it does not jump"
    assert len(by_hand(stroke((3, 3), (3, 3)).path, "on one spot")) == 2


def test_every_correction_is_done_by_strokes_of_a_bearable_length() -> None:
    _, corrections = read_corrections()
    assert [one.name for one in corrections] == list(brush.ACTIONS)
    paths = [act.path for actions in brush.ACTIONS.values() for act in actions if isinstance(act, Stroke)]
    assert max(sum(itertools.starmap(math.dist, itertools.pairwise(path))) for path in paths) < 180


def test_the_corrections_fit_their_frames() -> None:
    folder = frames_folder()
    if not folder.is_dir():
        pytest.skip(f"no test data in {folder}: set ILF_TEST_DATA to the folder that holds rgbd/")
    scenes, corrections = read_corrections()
    assert len(corrections) == 12
    with their_network():
        blocks = {name: extract_blocks(load_scene(scene, folder).frame) for name, scene in scenes.items()}
    for correction in corrections:
        before = blocks[correction.frame]
        target = target_map(before, correction)
        assert wrong_pixels(before, target, correction).any()
        assert not wrong_pixels(target, target, correction).any()

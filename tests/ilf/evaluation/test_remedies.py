"""Remedies for flagged places: each kind on blocks that have just that fault; and ignored places."""

import numpy as np
import pytest

from ilf.data.frame import RGBDFrame
from ilf.evaluation.quality.checks import find_places, propagated_places
from ilf.evaluation.quality.places import Place, ignore, without_ignored
from ilf.evaluation.quality.remedies import REMEDIES, Remedy, find_remedy

from .test_quality_checks import HEIGHT, NOWHERE, WIDTH, edge_at, frame_of, halves, holed, only_place, two_walls


def remedy_for(place: Place, frame: RGBDFrame, labels: np.ndarray, edge: np.ndarray, **options) -> Remedy:
    remedy = find_remedy(place, frame, labels, edge, **options)
    assert remedy.kind in REMEDIES
    return remedy


def mended(remedy: Remedy, labels: np.ndarray) -> np.ndarray:
    after = labels.copy()
    remedy.patch.apply(after)
    return after


def test_a_block_with_two_walls_is_split_between_them():
    frame, labels, edge = frame_of(holed(np.s_[30:50], np.s_[50:70])), np.ones_like(halves()), edge_at(60)
    place = only_place(find_places(frame, labels, edge))
    remedy = remedy_for(place, frame, labels, edge, first_new=7)
    assert (remedy.kind, remedy.text) == ("split", "Split Block 1")
    after = mended(remedy, labels)
    assert set(np.unique(after)) == {1, 7}
    assert np.mean((after == after[0, 0]) == (halves() == 1)) > 0.97
    assert find_places(frame, after, edge) == []
    assert find_remedy(place, frame, labels, edge, locked=[1]) is None


def test_what_a_moved_border_has_taken_in_is_given_back():
    frame, edge = frame_of(holed(np.s_[30:50], np.s_[61:71])), edge_at(60)
    place = only_place(find_places(frame, halves(75), edge))
    remedy = remedy_for(place, frame, halves(75), edge)
    assert (remedy.kind, remedy.text) == ("give", "Give a part of Block 1 to Block 2")
    assert np.mean(mended(remedy, halves(75)) == halves()) > 0.97
    # a lock of the neighbour leaves the split
    assert remedy_for(place, frame, halves(75), edge, locked=[2]).kind == "split"


def test_a_weak_border_has_no_remedy():
    labels = halves()
    labels[30:60, 60:76] = 1
    frame, edge = frame_of(holed(np.s_[20:70], np.s_[30:100])), edge_at(60)
    place = only_place(find_places(frame, labels, edge))
    assert place.kind == "border"
    assert find_remedy(place, frame, labels, edge) is None


def test_islands_and_holes_go_to_the_block_around_them_and_blocks_without_an_edge_are_merged():
    edge, labels = edge_at(59, 60), halves()
    labels[10:20, 20:30] = 2
    labels[40:45, 90:100] = 0
    labels[70:79, 80:91] = 3
    frame = frame_of(two_walls())
    found = {}
    for place in find_places(frame, labels, edge):
        remedy = remedy_for(place, frame, labels, edge)
        found[remedy.kind, remedy.text] = np.count_nonzero(mended(remedy, labels) != labels)
    assert found == {
        ("give", "Give a part of Block 2 to Block 1"): 100,
        ("give", "Give a hole to Block 2"): 50,
        ("merge", "Merge Block 3 into Block 2"): 99,
    }


def test_wrong_measured_depth_is_marked_as_invalid():
    """A speckle far from the wall in a hole of the depth: no part of the block, as a box there would be."""
    kinds = {}
    for size in (3, 20):
        depth = np.full((320, 400), 2.0)
        depth[150 : 170 + size, 170 : 190 + size] = np.nan
        depth[160 : 160 + size, 180 : 180 + size + 1] = 1.2
        frame, labels, edge = frame_of(depth), np.ones(depth.shape, np.int32), np.zeros(depth.shape, np.float32)
        edge[159 : 161 + size, 179 : 182 + size] = 1
        edge[161 : 159 + size, 181 : 180 + size] = 0
        place = find_places(frame, labels, edge)[0]
        remedy = remedy_for(place, frame, labels, edge)
        kinds[size] = remedy.kind
        if remedy.kind == "invalid":
            assert remedy.text == "Mark 12 px as invalid"
            assert np.array_equal(remedy.invalid, depth == 1.2)
    assert kinds == {3: "invalid", 20: "split"}


def test_a_high_expected_error_has_a_remedy():
    """Wrong depth near by is marked first; then the plane of the block is continued."""
    rows, columns = np.mgrid[:120, :160]
    truth = 1 / (1.0 + 0.002 * columns)
    depth, labels, edge = truth.copy(), np.ones(truth.shape, np.int32), np.zeros(truth.shape, np.float32)
    hole = (rows - 60) ** 2 + (columns - 80) ** 2 < 40**2
    speck = (rows - 65) ** 2 + (columns - 75) ** 2 < 12
    depth[hole] = np.nan
    depth[speck] = 12.0
    frame, error = frame_of(depth), np.where(hole & ~speck, np.float32(0.5), np.float32(np.nan))
    places = [place for place in find_places(frame, labels, edge, error) if place.kind == "error"]
    remedy = remedy_for(places[0], frame, labels, edge)
    assert remedy.text == f"Mark {np.count_nonzero(speck)} px as invalid"
    assert np.array_equal(remedy.invalid, speck)
    again = remedy_for(places[0], frame.with_more_invalid(remedy.invalid), labels, edge)
    assert again.text == "Continue the plane of Block 1"
    assert np.array_equal(np.isfinite(again.by_hand), hole)
    assert np.abs(again.by_hand - truth)[hole].max() < 0.001


def test_a_propagated_block_is_marked_as_checked():
    frame = frame_of(two_walls())
    place = propagated_places(halves(), {2: ""})[0]
    remedy = remedy_for(place, frame, halves(), NOWHERE)
    assert (remedy.kind, remedy.text, remedy.patch, remedy.invalid) == (
        "checked",
        "Mark Block 2 as checked",
        None,
        None,
    )


def test_an_ignored_place_counts_again_when_its_surroundings_change():
    frame, labels = frame_of(two_walls()), halves()
    place = Place("jump", (slice(30, 60), slice(58, 62)), (1,), (60.5, 45.5), 5.0, "")
    elsewhere, later = labels.copy(), labels.copy()
    elsewhere[:10] = 3
    later[50:55, 60:65] = 3
    ignored = [ignore(place, frame, labels)]
    moved = Place("jump", place.box, (1, 4), (65.5, 50.5), 4.0, "")
    others = [
        Place("border", place.box, (1,), place.point, 5.0, ""),
        Place("jump", place.box, (2,), place.point, 5.0, ""),
        Place("jump", place.box, (1,), (60.5, 80.5), 5.0, ""),
    ]
    assert without_ignored([place, moved, *others], ignored, frame, labels) == others
    assert without_ignored([place], ignored, frame, elsewhere) == []
    assert without_ignored([place], ignored, frame, later) == [place]
    mask = np.zeros(frame.shape, bool)
    mask[45, 60] = True
    assert without_ignored([place], ignored, frame.with_invalid_mask(mask), labels) == [place]


@pytest.mark.parametrize("point", [(0.5, 0.5), (WIDTH - 0.5, HEIGHT - 0.5)])
def test_places_in_the_corners_can_be_ignored(point):
    frame = frame_of(two_walls())
    place = Place("jump", (slice(0, 1), slice(0, 1)), (1,), point, 5.0, "")
    assert without_ignored([place], [ignore(place, frame, halves())], frame, halves()) == []

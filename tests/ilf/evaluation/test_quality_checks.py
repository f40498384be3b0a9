"""Suspicious places: each kind on a frame that has just that fault, and none where nothing matters."""

import numpy as np

from ilf.data.frame import RGBDFrame
from ilf.evaluation.quality.checks import find_places
from ilf.evaluation.quality.places import KINDS

HEIGHT, WIDTH = 90, 120


def frame_of(depth: np.ndarray) -> RGBDFrame:
    return RGBDFrame(np.full((*depth.shape, 3), 90, np.uint8), depth)


def two_walls(step: float = 0.5) -> np.ndarray:
    """A slanted wall that ends at column 60, and another one behind it."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return 1.5 + 0.002 * rows + np.where(columns < 60, 0.0, step)


def halves(column: int = 60) -> np.ndarray:
    labels = np.ones((HEIGHT, WIDTH), np.int32)
    labels[:, column:] = 2
    return labels


NOWHERE = np.zeros((HEIGHT, WIDTH), np.float32)


def holed(rows: slice, columns: slice, step: float = 0.5) -> np.ndarray:
    """The two walls with missing depth."""
    depth = two_walls(step)
    depth[rows, columns] = np.nan
    return depth


def edge_at(*columns: int) -> np.ndarray:
    edge = NOWHERE.copy()
    edge[:, columns] = 1
    return edge


def only_place(places):
    assert len(places) == 1, [place.reason for place in places]
    assert places[0].kind in KINDS
    return places[0]


def test_right_blocks_raise_no_suspicion():
    depth = holed(np.s_[20:60], np.s_[40:80])
    edge = edge_at(60)
    assert find_places(frame_of(depth), halves(), edge) == []


def test_border_across_a_plane_does_no_harm():
    depth = holed(np.s_[20:60], np.s_[40:80], step=0.0)
    labels = halves()
    labels[50:, 20:90] = 3
    assert find_places(frame_of(depth), labels, NOWHERE) == []


def test_depth_jumps_inside_a_block():
    depth = holed(np.s_[30:50], np.s_[62:90])
    place = only_place(find_places(frame_of(depth), np.ones_like(halves()), NOWHERE))
    assert place.kind == "jump"
    assert place.labels == (1,)
    assert place.reason == "Depth jumps by 0.50 m inside Block 1."
    assert abs(place.point[0] - 60) <= 2
    assert place.box[0] == slice(0, HEIGHT)
    assert place.box[1].start <= 59 < place.box[1].stop


def test_moved_border_leaves_a_jump_beside_it():
    depth = holed(np.s_[30:50], np.s_[61:71])
    place = only_place(find_places(frame_of(depth), halves(75), NOWHERE))
    assert place.labels == (1,)
    assert abs(place.point[0] - 60) <= 8


def test_two_surfaces_that_missing_depth_parts():
    depth = holed(np.s_[:], np.s_[52:68])
    edge = edge_at(60)
    place = only_place(find_places(frame_of(depth), np.ones_like(halves()), edge))
    assert place.kind == "surfaces"
    assert place.reason == "Block 1 contains two surfaces, at 1.59 m and 2.09 m."
    assert 52 <= place.point[0] < 68


def test_doubt_grows_where_no_edge_is_seen():
    depth = holed(np.s_[:], np.s_[52:68])
    edge = edge_at(60)
    seen, unseen = (find_places(frame_of(depth), np.ones_like(halves()), one)[0] for one in (edge, NOWHERE))
    assert unseen.score < 0.5 * seen.score


def test_one_plane_behind_a_gap_is_one_surface():
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    depth = 1 / (0.3 + 0.002 * columns + 0.001 * rows)  # a plane, steep enough to differ by metres
    depth[:, 40:80] = np.nan
    assert find_places(frame_of(depth), np.ones_like(halves()), NOWHERE) == []


def test_border_beside_its_edge_in_missing_depth():
    depth = holed(np.s_[20:70], np.s_[30:100])
    edge = edge_at(60)
    labels = halves()
    labels[30:60, 60:76] = 1
    place = only_place(find_places(frame_of(depth), labels, edge))
    assert place.kind == "border"
    assert set(place.labels) == {1, 2}
    assert "0.50 m apart" in place.reason
    assert abs(place.point[0] - 76) <= 2


def test_a_border_does_less_harm_the_nearer_another_edge_is():
    depth = holed(np.s_[20:70], np.s_[30:100])
    labels = halves()
    labels[30:60, 60:76] = 1
    scores = []
    for columns in ([60], [60, 88], [60, 84]):
        scores.append(only_place(find_places(frame_of(depth), labels, edge_at(*columns))).score)
    assert scores[0] > scores[1] > scores[2]


def test_high_expected_error_counts_where_it_is_given():
    depth = holed(np.s_[20:60], np.s_[10:50])
    edge = edge_at(60)
    error = np.where(np.isnan(depth), np.float32(0.24), np.float32(np.nan))
    assert find_places(frame_of(depth), halves(), edge) == []
    place = only_place(find_places(frame_of(depth), halves(), edge, error))
    assert (place.kind, place.labels) == ("error", (1,))
    assert place.reason == "Expected error 240 mm over 1,600 px of Block 1."


def test_islands_holes_and_slivers():
    edge = edge_at(59, 60)
    labels = halves()
    labels[10:20, 20:30] = 2
    labels[40:45, 90:100] = 0
    labels[70:72, 80:110] = 3
    found = {place.reason for place in find_places(frame_of(two_walls()), labels, edge)}
    assert found == {
        "An island of 100 px of Block 2 lies in Block 1, apart from the rest.",
        "A hole of 50 px in Block 2 belongs to no block.",
        "A sliver of 60 px of Block 3 lies along Block 2.",
    }


def test_block_inside_another_counts_if_nothing_parts_them():
    labels = halves()
    labels[30:40, 20:30] = 3
    edge = edge_at(59, 60)
    place = only_place(find_places(frame_of(two_walls()), labels, edge))
    assert place.reason == "Block 3, 100 px, lies inside Block 1 without an edge between them."
    edge[29:41, 19:31] = 1
    assert find_places(frame_of(two_walls()), labels, edge) == []


def test_worst_place_comes_first_and_scores_are_metres_times_pixels():
    depth = two_walls()
    depth[5:30, 61:80] = np.nan
    depth[60:62, 61:63] = np.nan
    labels = np.ones_like(halves())
    labels[45:] = 2
    places = find_places(frame_of(depth), labels, NOWHERE)
    assert [place.labels for place in places] == [(1,), (2,)]
    # half of the missing pixels in reach count, at half a metre
    assert 0.5 * 25 * 19 * 0.3 < places[0].score < 0.5 * 25 * 19

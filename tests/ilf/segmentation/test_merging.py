"""Merging of regions against direct formulas: what a border costs, in which order regions unite, and what is unfit."""

from dataclasses import replace

import numpy as np
import pytest

from ilf.data.frame import RGBDFrame
from ilf.segmentation.edges.frame_edges import Relief
from ilf.segmentation.merging import RegionGraph, numbered

ANY = (0, 0.0, 0)
"""What is required of pixels, share and number of known pixels of a block: nothing."""


def _frame(depth):
    return RGBDFrame(np.zeros((*depth.shape, 3), np.uint8), depth)


def _flat(shape):
    return _frame(np.full(shape, 2.0))


def _relief(shape, evaluated=True, bend=0.0):
    """What depth would say that jumps nowhere, and is missing where it is not evaluated."""
    height, width = shape
    nowhere = np.zeros((height, width - 1), bool), np.zeros((height - 1, width), bool)
    evaluated = np.broadcast_to(evaluated, shape)
    bend = np.where(evaluated, np.broadcast_to(bend, shape), 0).astype(np.float32)
    return Relief(evaluated, nowhere, nowhere, evaluated, bend, np.ones(shape, np.float32))


def _columns(*widths, height=4):
    """Regions 1, 2, ... side by side."""
    return np.tile(np.repeat(np.arange(1, len(widths) + 1), widths), (height, 1)).astype(np.int32)


def _partners(labels, regions):
    """Which regions have become one, as sets of their numbers; those in no block are left out."""
    groups = {}
    for region in np.unique(regions[regions > 0]):
        (label,) = np.unique(labels[regions == region])
        if label:
            groups.setdefault(int(label), set()).add(int(region))
    return {frozenset(group) for group in groups.values()}


def _sets(*groups):
    return {frozenset(map(int, group)) for group in groups}


def _merged(regions, strength, limit, relief=None, frame=None):
    graph = RegionGraph(regions, strength.astype(np.float32), frame or _flat(regions.shape), relief)
    graph.merge_below(limit)
    return _partners(graph.labels(), regions)


def _cost(strength, relief, frame=None, regions=None):
    """What the border between regions 1 and 2 costs: the limit at which they merge, by bisection."""
    regions = _columns(6, 6) if regions is None else regions
    low, high = 0.0, 20.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if len(_merged(regions, strength, middle, relief, frame)) == 1 else (middle, high)
    return low


def _with_jumps(relief, count):
    """Jumps between the columns 5 and 6, in so many rows."""
    right = relief.jumps[0].copy()
    right[:count, 5] = True
    return replace(relief, jumps=(right, relief.jumps[1]))


# what a border costs


def test_where_depth_goes_on_an_edge_of_colour_counts_a_tenth():
    strength = np.full((4, 12), 0.6)
    assert _cost(strength, _relief((4, 12))) == pytest.approx(0.06, rel=1e-5)


@pytest.mark.parametrize(
    ("bend", "expected"), [(0.4, 0.0), (0.5, 0.0), (1.5, 0.2), (3.0, 0.5), (7.0, 0.5)], ids=lambda value: f"{value:g}"
)
def test_a_bend_costs_a_fifth_of_what_it_is_above_a_half_up_to_three(bend, expected):
    cost = _cost(np.full((4, 12), 0.3), _relief((4, 12), bend=bend))
    assert cost == pytest.approx(expected + 0.03, rel=1e-5)


def test_the_bend_of_a_border_is_the_mean_over_its_judged_pairs_of_the_larger_one():
    evaluated = np.ones((4, 12), bool)
    evaluated[3, 6] = False
    bend = np.zeros((4, 12))
    bend[:3, 5], bend[:3, 6], bend[3, 5] = 1.0, (2.0, 0.5, 0.9), 3.0
    mean = (2.0 + 1.0 + 1.0) / 3
    on_surface = 0.2 * (mean - 0.5) + 0.1 * 0.4
    expected = 0.25 * 0.4 + 0.75 * on_surface
    assert _cost(np.full((4, 12), 0.4), _relief((4, 12), evaluated, bend)) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("rows", [0, 1, 2, 3, 4])
def test_what_depth_does_not_see_of_a_border_counts_in_full(rows):
    """Too few pixels for a plane, so that colour has the say in the rest."""
    evaluated = np.zeros((4, 12), bool)
    evaluated[:rows] = True
    seen = rows / 4
    expected = (1 - seen) * 0.4 + seen * 0.1 * 0.4
    assert _cost(np.full((4, 12), 0.4), _relief((4, 12), evaluated)) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("jumps", "expected"), [(0, 0.04), (2, 0.04), (3, 9 + 3 / 4), (4, 10.0)])
def test_more_than_two_jumps_keep_regions_apart(jumps, expected):
    relief = _with_jumps(_relief((4, 12)), jumps)
    assert _cost(np.full((4, 12), 0.4), relief) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("jumps", "apart"), [(8, False), (9, True)])
def test_jumps_along_two_hundredths_of_a_long_border_do_not_part(jumps, apart):
    relief = _with_jumps(_relief((400, 12)), jumps)
    assert (_cost(np.zeros((400, 12)), relief, regions=_columns(6, 6, height=400)) > 9) == apart


# planes: 2 x 40 x 40 pixels, of which every second along rows and columns is looked at: 400 a region


def _wide(depth, seen_rows=0):
    """Cost of the border between two regions of 40 x 40 pixels of edge strength 0.5."""
    evaluated = np.zeros(depth.shape, bool)
    evaluated[:seen_rows] = True
    return _cost(np.full(depth.shape, 0.5), _relief(depth.shape, evaluated), _frame(depth), _columns(40, 40, height=40))


ROWS, COLUMNS = np.mgrid[:40, :80]
APART = np.where((COLUMNS >= 36) & (COLUMNS < 44), np.nan, 1.0)
"""A gap at the border."""


def _plane(columns=0.002, rows=0.001):
    return APART / (0.5 + columns * COLUMNS + rows * ROWS)


def test_an_edge_between_regions_on_one_plane_counts_a_fifth():
    assert _wide(_plane()) == pytest.approx(0.1, rel=1e-5)
    assert _wide(_plane(0.0, 0.0)) == pytest.approx(0.1, rel=1e-5)
    assert _wide(_plane(-0.003, 0.004)) == pytest.approx(0.1, rel=1e-5)


@pytest.mark.parametrize(("rows", "expected"), [(19, 0.1), (20, 0.5), (40, 0.5)])
def test_planes_count_where_less_than_half_of_the_border_is_seen(rows, expected):
    seen = rows / 40
    assert _wide(_plane(), rows) == pytest.approx((1 - seen) * expected + seen * 0.1 * expected, rel=1e-5)


@pytest.mark.parametrize("depth", [1.0, 2.0, 8.0])
@pytest.mark.parametrize(("factor", "shared"), [(0.9, True), (1.1, False)])
def test_a_plane_holds_both_up_to_one_percent_or_three_thousandths_per_metre(depth, factor, shared):
    """Regions parted in depth by an inverse-depth step that a plane over the image cannot follow: a checker pattern."""
    allowed = max(0.01, 0.003 * depth)
    share = factor * allowed
    pattern = np.where((ROWS // 2 + COLUMNS // 2) % 2 == 0, 1 + share, 1 - share)
    cost = _wide(APART * depth / pattern)
    assert cost == pytest.approx(0.1 if shared else 0.5, rel=1e-5)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(("known", "expected"), [(98, 0.5), (100, 0.1)])
def test_a_plane_needs_fifty_of_the_pixels_that_are_looked_at_in_either_region(side, known, expected):
    depth = _plane()
    poor = (COLUMNS >= 40) if side else (COLUMNS < 40)
    depth[poor & (ROWS >= 2)] = np.nan
    rows = (ROWS < 2) & poor
    depth[rows] = np.nan
    looked_at = np.argwhere(poor & (ROWS % 2 == 0) & (COLUMNS % 2 == 0))[: known // 2]
    depth[tuple(looked_at.T)] = 1 / (0.5 + 0.002 * looked_at[:, 1] + 0.001 * looked_at[:, 0])
    assert _wide(depth) == pytest.approx(expected, rel=1e-5)


def test_a_region_is_on_the_plane_of_all_that_it_has_taken_in():
    """2 and 3 are on one plane, 1 is not; what 1 and 2 are together is on no plane with 3."""
    columns = np.mgrid[:40, :120][1]
    depth = np.where(columns < 40, 3.0, 2.0)
    depth[:, [*range(36, 44), *range(76, 84)]] = np.nan
    strength = np.zeros(depth.shape)
    strength[:, 39:41], strength[:, 79:81] = 0.05, 0.3
    regions = _columns(40, 40, 40, height=40)
    nowhere = np.zeros(depth.shape, bool)

    def merged(limit):
        return _merged(regions, strength, limit, _relief(depth.shape, nowhere), _frame(depth))

    assert merged(0.04) == _sets("1", "2", "3")
    assert merged(0.055) == _sets("12", "3")  # 0.05 comes before 0.06
    assert merged(0.2) == _sets("12", "3"), "0.06 has risen to 0.3"
    assert merged(0.31) == _sets("123")


# the order


@pytest.mark.parametrize("seed", range(12))
def test_any_graph_ends_as_a_slow_search_for_the_least_border_does(seed):
    rng = np.random.default_rng(seed)
    coarse = rng.permutation(np.arange(1, 26)).reshape(5, 5)
    regions = np.kron(coarse, np.ones((4, 4))).astype(np.int32)
    strength = rng.uniform(0.0, 1.0, (20, 20)).astype(np.float32)
    for limit in (0.45, 0.6, 0.65):
        expected = regions.copy()
        while True:
            borders = {}
            for here, there, a, b in (
                (expected[:, 1:], expected[:, :-1], strength[:, 1:], strength[:, :-1]),
                (expected[1:], expected[:-1], strength[1:], strength[:-1]),
            ):
                for one, other, edge in zip(here.ravel(), there.ravel(), np.maximum(a, b).ravel(), strict=True):
                    if one != other:
                        borders.setdefault((min(one, other), max(one, other)), []).append(float(edge))
            least, pair = min((float(np.mean(edges)), pair) for pair, edges in borders.items())
            if least >= limit:
                break
            expected[expected == pair[1]] = pair[0]
            if len(np.unique(expected)) == 1:
                break
        assert _merged(regions, strength, limit) == _partners(expected, regions)


# what is unfit


def _taken_in(regions, strength, fitness, depth):
    graph = RegionGraph(regions, strength.astype(np.float32), _frame(depth), None)
    graph.merge_unfit(*fitness)
    return _partners(graph.labels(), regions)


def test_small_regions_go_to_the_neighbour_they_are_least_parted_from():
    regions = _columns(5, 2, 5)
    depth, strength = np.full(regions.shape, 2.0), np.zeros(regions.shape)
    strength[:, 5], strength[:, 7] = 0.4, 0.3
    assert _taken_in(regions, strength, (8, 0.0, 0), depth) == _sets("1", "2", "3"), "8 pixels are enough"
    assert _taken_in(regions, strength, (8.5, 0.0, 0), depth) == _sets("1", "23")
    strength[:, 7] = 0.5
    assert _taken_in(regions, strength, (9, 0.0, 0), depth) == _sets("12", "3")
    strength[:, 7] = 0.4
    assert _taken_in(regions, strength, (9, 0.0, 0), depth) == _sets("12", "3"), "the first of two alike"


@pytest.mark.parametrize(("pixels", "own"), [(80, True), (81, False)])
@pytest.mark.parametrize("jumps", [0, 4])
def test_what_jumps_part_from_all_others_is_a_block_from_a_fifth_of_the_size_on(pixels, own, jumps):
    regions = _columns(4, 30)
    strength = np.zeros(regions.shape, np.float32)
    right = np.zeros((4, 33), bool)
    right[:jumps, 3] = True
    relief = replace(_relief(regions.shape), jumps=(right, np.zeros((3, 34), bool)))
    graph = RegionGraph(regions, strength, _flat(regions.shape), relief)
    graph.merge_unfit(pixels, 0.0, 0)
    assert (graph.labels().max() == 2) == (own and jumps > 0)


def test_the_smallest_goes_first_and_counts_for_the_one_that_takes_it_in():
    regions = _columns(3, 2, 10)
    depth, strength = np.full(regions.shape, 2.0), np.zeros(regions.shape)
    strength[:, 3], strength[:, 5] = 0.1, 0.9
    assert _taken_in(regions, strength, (20, 0.0, 0), depth) == _sets("12", "3"), "12 + 8 pixels are enough"
    assert _taken_in(regions, strength, (21, 0.0, 0), depth) == _sets("123")
    # were 1 the first, it would take 2 away from 3
    strength[:, 3], strength[:, 5] = 0.9, 0.1
    assert _taken_in(regions, strength, (12, 0.0, 0), depth) == _sets("1", "23")
    assert _taken_in(regions, strength, (13, 0.0, 0), depth) == _sets("123"), "then 1 is alone"


@pytest.mark.parametrize(
    ("known", "share", "pixels", "fit"),
    [(7, 0.5, 0, False), (8, 0.5, 0, True), (4, 0.01, 5, False), (5, 0.01, 5, True), (4, 0.0, 5, True)],
)
def test_a_share_of_a_region_and_so_many_pixels_must_be_known_unless_nothing_is_asked_of_it(known, share, pixels, fit):
    regions = _columns(4, 6)
    depth, strength = np.full(regions.shape, 2.0), np.zeros(regions.shape)
    places = np.argwhere(regions == 1)
    depth[tuple(places[known:].T)] = np.nan
    fitness = (0, share, pixels)
    assert _taken_in(regions, strength, fitness, depth) == (_sets("1", "2") if fit else _sets("12"))
    depth[regions == 1] = np.nan
    assert share or _taken_in(regions, strength, fitness, depth) == _sets("2"), "nor goes it to another"


def test_what_has_no_neighbours_is_a_block_unless_nothing_of_it_is_known():
    regions = np.zeros((6, 9), np.int32)
    regions[:, :2], regions[:, 4], regions[:, 6:] = 1, 2, 3
    depth, strength = np.full(regions.shape, 2.0), np.zeros(regions.shape)
    depth[regions == 2] = np.nan
    depth[1:, 6:] = depth[0, 7:] = np.nan
    for fitness in ((1000, 0.5, 30), ANY):
        assert _taken_in(regions, strength, fitness, depth) == _sets("1", "3"), "one pixel of 3 is known"
        swapped = np.array([0, 2, 1, 3], np.int32)[regions]
        assert _taken_in(swapped, strength, fitness, depth) == _sets("2", "3")


# numbers


def test_blocks_are_numbered_from_the_largest_down_and_the_first_of_two_alike_comes_first():
    labels = np.array([[7, 7, 7, 0], [9, 3, 3, 0], [5, 5, 2, 2]], np.int32)
    found = numbered(labels)
    assert found.dtype == np.int32
    assert found.tolist() == [[1, 1, 1, 0], [5, 3, 3, 0], [4, 4, 2, 2]]
    assert numbered(np.zeros((2, 3), np.int32)).tolist() == [[0] * 3] * 2
    assert numbered(np.full((2, 3), 4)).tolist() == [[1] * 3] * 2

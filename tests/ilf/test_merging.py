"""Merging of regions: what a border costs, which regions become one, and which cannot be blocks."""

from __future__ import annotations

import numpy as np
import pytest

from ilf.ebs.merging import Fitness, RegionGraph, numbered
from ilf.edges.relief import Relief
from ilf.frame import RGBDFrame

HIGH, WIDE = 24, 48
HALVES = np.repeat([[1, 2]], HIGH, axis=0).repeat(WIDE // 2, axis=1).astype(np.int32)
"""Region 1 on the left, 2 on the right; their border is 24 px long."""
LEFT, RIGHT = WIDE // 2 - 1, WIDE // 2
"""The columns on either side of the border."""
ANY = Fitness(0, 0.0, 0)


def frame_of(depth: float | np.ndarray = 2.0, shape: tuple[int, int] = (HIGH, WIDE)) -> RGBDFrame:
    return RGBDFrame(np.zeros((*shape, 3), np.uint8), np.broadcast_to(depth, shape))


def relief_of(
    shape: tuple[int, int] = (HIGH, WIDE),
    judged: np.ndarray | bool = False,
    bend: np.ndarray | float = 0.0,
    jumps: np.ndarray | None = None,
) -> Relief:
    """A relief with jumps between left and right neighbours, bool (H, W - 1)."""
    right = np.zeros((shape[0], shape[1] - 1), bool) if jumps is None else jumps
    below = np.zeros((shape[0] - 1, shape[1]), bool)
    bends = np.broadcast_to(np.float32(bend), shape)
    return Relief(np.ones(shape, bool), (right, below), (right, below), np.broadcast_to(judged, shape), bends)


def merged(
    regions: np.ndarray,
    strength: np.ndarray,
    limit: float,
    depth: float | np.ndarray = 2.0,
    relief: Relief | None = None,
) -> np.ndarray:
    graph = RegionGraph(regions, strength, frame_of(depth, regions.shape), relief)
    graph.merge_below(limit)
    return graph.labels()


def cost_of_border(strength: np.ndarray, depth: float | np.ndarray = 2.0, relief: Relief | None = None) -> float:
    """The limit from which on the two halves are one block, to 1e-6."""
    low, high = 0.0, 16.0
    while high - low > 1e-6:
        middle = (low + high) / 2
        if merged(HALVES, strength, middle, depth, relief).max() == 1:
            high = middle
        else:
            low = middle
    return high


def edge_of(left: float, right: float | None = None, rows: slice = np.s_[:]) -> np.ndarray:
    """Edge strength at the border of the halves, in some rows."""
    strength = np.zeros((HIGH, WIDE), np.float32)
    strength[rows, LEFT] = left
    strength[rows, RIGHT] = left if right is None else right
    return strength


# what a border costs


def test_edges_alone_cost_the_mean_of_the_stronger_side() -> None:
    assert cost_of_border(edge_of(0.25, 0.5)) == pytest.approx(0.5, abs=2e-6)
    assert cost_of_border(edge_of(0.5, 0.25)) == pytest.approx(0.5, abs=2e-6)
    assert cost_of_border(edge_of(0.5, rows=np.s_[:6])) == pytest.approx(0.125, abs=2e-6)
    elsewhere = np.full((HIGH, WIDE), 1.0, np.float32)
    elsewhere[:, [LEFT, RIGHT]] = 0.25
    assert cost_of_border(elsewhere) == pytest.approx(0.25, abs=2e-6)


def test_a_border_that_costs_the_limit_stays() -> None:
    assert merged(HALVES, edge_of(0.5), 0.5).max() == 2
    assert merged(HALVES, edge_of(0.5), 0.5000001).max() == 1


@pytest.mark.parametrize(("count", "cost"), [(2, 0.0), (3, 9 + 3 / HIGH), (HIGH, 10.0)])
def test_more_than_two_jumps_keep_regions_apart_whatever_the_edges(count: int, cost: float) -> None:
    jumps = np.zeros((HIGH, WIDE - 1), bool)
    jumps[:count, LEFT] = True
    jumps[:, 3] = True  # inside a region: no border
    assert cost_of_border(edge_of(0.0), relief=relief_of(jumps=jumps)) == pytest.approx(cost, abs=2e-6)


@pytest.mark.parametrize(
    ("bend", "cost"), [(0.0, 0.05), (0.5, 0.05), (1.5, 0.2 + 0.05), (3.0, 0.5 + 0.05), (50.0, 0.5 + 0.05)]
)
def test_a_bend_costs_up_to_its_sharpest_and_edges_on_a_surface_count_a_tenth(bend: float, cost: float) -> None:
    relief = relief_of(judged=True, bend=bend)
    assert cost_of_border(edge_of(0.5), relief=relief) == pytest.approx(cost, abs=2e-6)


def test_a_bend_is_the_larger_of_both_sides_and_the_mean_along_the_border() -> None:
    bend = np.zeros((HIGH, WIDE))
    bend[:, LEFT] = 0.25
    bend[: HIGH // 2, RIGHT] = 2.75  # 2.75 in one half of the rows and 0.25 in the other
    relief = relief_of(judged=True, bend=bend)
    assert cost_of_border(edge_of(0.0), relief=relief) == pytest.approx(0.2 * (1.5 - 0.5), abs=2e-6)


def test_only_pixels_judged_on_both_sides_say_that_the_surface_goes_on() -> None:
    """The part of the border that is seen counts as surface, the rest with its edges."""
    rows, columns = np.indices((HIGH, WIDE))
    relief = relief_of(judged=(rows < 18), bend=1.5)
    expected = 0.25 * 0.5 + 0.75 * (0.2 + 0.1 * 0.5)
    assert cost_of_border(edge_of(0.5), relief=relief) == pytest.approx(expected, abs=2e-6)
    one_side = relief_of(judged=columns < RIGHT, bend=1.5)
    far = np.where(columns < RIGHT, 2.0, 3.0)
    assert cost_of_border(edge_of(0.5), far, one_side) == pytest.approx(0.5, abs=2e-6)


def slanted(offset: float, distance: float = 2.0) -> np.ndarray:
    """A plane as the camera sees it, and on the right the same with its inverse depth that share larger."""
    rows, columns = np.indices((HIGH, WIDE))
    inverse = (1 + 0.1 * columns / WIDE + 0.2 * rows / HIGH) / distance
    return 1 / np.where(columns < RIGHT, inverse, inverse * (1 + offset))


def test_edges_count_a_fifth_where_one_plane_holds_both_regions() -> None:
    unseen = relief_of()
    assert cost_of_border(edge_of(0.5), slanted(0.0), unseen) == pytest.approx(0.1, abs=2e-6)
    assert cost_of_border(edge_of(0.5), slanted(0.2), unseen) == pytest.approx(0.5, abs=2e-6)
    assert cost_of_border(edge_of(0.5), slanted(0.0)) == pytest.approx(0.5, abs=2e-6), "without relief edges decide"


def test_a_plane_may_be_rougher_in_the_distance() -> None:
    assert cost_of_border(edge_of(0.5), slanted(0.05), relief_of()) == pytest.approx(0.5, abs=2e-6)
    assert cost_of_border(edge_of(0.5), slanted(0.05, 8.0), relief_of()) == pytest.approx(0.1, abs=2e-6)


def test_the_largest_deviation_from_a_plane_is_one_hundredth_nearby() -> None:
    """Stripes of +- d about a plane deviate by d, root mean square."""
    rows = np.indices((HIGH, WIDE))[0]
    for deviation, cost in ((0.0095, 0.1), (0.0105, 0.5)):
        stripes = slanted(0.0) / (1 + deviation * np.where(rows // 2 % 2, 1, -1))
        assert cost_of_border(edge_of(0.5), stripes, relief_of()) == pytest.approx(cost, abs=2e-6)


@pytest.mark.parametrize(("known_rows", "cost"), [(10, 0.1), (8, 0.5)])
def test_a_plane_takes_fifty_pixels_in_each_region(known_rows: int, cost: float) -> None:
    """Every second row and column is looked at: 12 columns of a region, so 10 rows are 60 pixels, and 8 are 48."""
    depth = slanted(0.0)
    depth[known_rows:, RIGHT:] = np.nan
    assert cost_of_border(edge_of(0.5), depth, relief_of()) == pytest.approx(cost, abs=2e-6)


def test_the_plane_is_not_asked_where_half_of_the_border_is_seen() -> None:
    rows = np.indices((HIGH, WIDE))[0]
    half, less = relief_of(judged=rows < 12), relief_of(judged=rows < 11)
    assert cost_of_border(edge_of(0.5), slanted(0.0), half) == pytest.approx(0.5 * 0.5 + 0.5 * 0.05, abs=2e-6)
    seen = 11 / HIGH
    expected = (1 - seen) * 0.1 + seen * 0.01
    assert cost_of_border(edge_of(0.5), slanted(0.0), less) == pytest.approx(expected, abs=2e-6)


# which regions become one


def strips(*widths: int, high: int = 4) -> np.ndarray:
    """Regions 1, 2, ... from left to right."""
    return np.repeat(np.arange(1, len(widths) + 1, dtype=np.int32), widths)[None].repeat(high, axis=0)


def borders(regions: np.ndarray, *values: float) -> np.ndarray:
    """Strength at the borders between neighbouring strips, from left to right, on their right side."""
    strength = np.zeros(regions.shape, np.float32)
    for column, value in zip(np.flatnonzero(np.diff(regions[0])) + 1, values, strict=True):
        strength[:, column] = value
    return strength


def test_neighbours_below_the_limit_become_one() -> None:
    regions = strips(6, 5, 4, 3)
    labels = merged(regions, borders(regions, 0.1, 0.6, 0.2), 0.5)
    np.testing.assert_array_equal(labels, np.where(regions < 3, 1, 2))
    assert labels.dtype == np.int32


def test_no_border_runs_over_pixels_of_no_region_or_diagonally() -> None:
    regions = np.array([[1, 0, 2], [0, 0, 0], [3, 0, 0], [0, 4, 0]], np.int32)
    assert merged(regions, np.zeros((4, 3), np.float32), 9.0).max() == 4


def test_one_region_and_none_at_all() -> None:
    strength = np.zeros((3, 4), np.float32)
    assert (merged(np.ones((3, 4), np.int32), strength, 1.0) == 1).all()
    assert (merged(np.zeros((3, 4), np.int32), strength, 1.0) == 0).all()


def test_borders_above_and_below_count_as_those_to_the_side() -> None:
    regions = strips(6, 5, 4, 3)
    strength = borders(regions, 0.1, 0.6, 0.2)
    labels = merged(regions, strength, 0.5)
    np.testing.assert_array_equal(merged(regions.T.copy(), strength.T.copy(), 0.5), labels.T)


def test_a_united_region_has_the_borders_of_both() -> None:
    """1 and 2, one above the other, unite first; what parts them from 3 is then the mean along the whole of it."""
    regions = np.array([[1, 1, 3, 3]] * 3 + [[2, 2, 3, 3]], np.int32)
    strength = np.zeros((4, 4), np.float32)
    strength[:3, 2], strength[3, 2] = 0.5, 0.25  # the mean is 0.4375, nearer to that of 1
    assert merged(regions, strength, 0.43).max() == 2
    assert merged(regions, strength, 0.44).max() == 1
    np.testing.assert_array_equal(merged(regions, strength, 0.43), numbered(np.where(regions == 3, 2, 1)))


def test_a_border_that_only_one_of_the_united_has_stays_as_it_is() -> None:
    regions = strips(4, 4, 4, 4)
    strength = borders(regions, 0.5, 0.0, 0.5)
    np.testing.assert_array_equal(merged(regions, strength, 0.5), np.choose(regions - 1, [2, 1, 1, 3]))
    assert merged(regions, strength, 0.50001).max() == 1


def test_the_least_parted_neighbours_unite_first() -> None:
    """2 could go with 1 or with 3; once it is with 3, to which no jump parts it, three jumps part both from 1."""
    regions = strips(4, 4, 4)
    jumps = np.zeros((4, 11), bool)
    jumps[:2, 3] = True  # 1 | 2: two of four, which do not part yet
    labels = merged(regions, borders(regions, 0.3, 0.2), 0.25, relief=relief_of((4, 12), jumps=jumps))
    np.testing.assert_array_equal(labels, [[2] * 4 + [1] * 8] * 4)


def test_a_region_that_took_in_another_plane_is_looked_at_again() -> None:
    """1 and 2 lie on one plane, 3 on another. Once 2 and 3 are one, no plane holds 1 and them: the edge counts."""
    regions = np.repeat(np.arange(1, 4, dtype=np.int32), 24)[None].repeat(24, axis=0)
    depth = np.where(np.arange(72) < 48, 2.0, 2.6)[None].repeat(24, axis=0)
    strength = borders(regions, 0.5, 0.05)
    labels = merged(regions, strength, 0.2, depth, relief_of((24, 72)))
    np.testing.assert_array_equal(labels, np.where(regions == 1, 2, 1))
    flat = merged(regions, strength, 0.2, 2.0, relief_of((24, 72)))
    assert flat.max() == 1


# which regions cannot be blocks


def fit(regions: np.ndarray, strength: np.ndarray, fitness: Fitness, depth: float | np.ndarray = 2.0) -> np.ndarray:
    graph = RegionGraph(regions, strength, frame_of(depth, regions.shape), None)
    graph.take_in_unfit(fitness)
    return graph.labels()


def test_a_region_that_is_too_small_goes_to_the_neighbour_it_is_least_parted_from() -> None:
    regions = strips(6, 2, 5)
    np.testing.assert_array_equal(
        fit(regions, borders(regions, 0.4, 0.2), Fitness(9, 0.0, 0)), np.where(regions == 1, 2, 1)
    )
    np.testing.assert_array_equal(
        fit(regions, borders(regions, 0.2, 0.4), Fitness(9, 0.0, 0)), np.where(regions < 3, 1, 2)
    )
    assert fit(regions, borders(regions, 0.2, 0.4), Fitness(8, 0.0, 0)).max() == 3, "8 pixels are enough for 8"


def test_of_equally_parted_neighbours_the_first_takes_it() -> None:
    regions = strips(4, 1, 4)
    np.testing.assert_array_equal(
        fit(regions, borders(regions, 0.3, 0.3), Fitness(5, 0.0, 0)), np.where(regions < 3, 1, 2)
    )


def test_small_regions_unite_until_they_are_large_enough_the_smallest_first() -> None:
    """2 (8 px) goes to 3 (12 px); with 20 they are large enough, and 3 need not go to 4."""
    regions = strips(8, 2, 3, 8)
    labels = fit(regions, borders(regions, 0.9, 0.1, 0.2), Fitness(20, 0.0, 0))
    np.testing.assert_array_equal(labels, np.choose(regions - 1, [1, 3, 3, 2]))
    labels = fit(regions, borders(regions, 0.9, 0.1, 0.2), Fitness(21, 0.0, 0))
    np.testing.assert_array_equal(labels, np.choose(regions - 1, [2, 1, 1, 1]))


@pytest.mark.parametrize(("known", "blocks"), [(10, 2), (9, 1)])
def test_a_region_needs_its_share_of_known_depth(known: int, blocks: int) -> None:
    regions = strips(10, 10, high=10)
    depth = np.full(regions.shape, 2.0)
    depth[:, 10:] = np.nan
    depth.reshape(-1)[np.flatnonzero(regions == 2)[:known]] = 2.0
    assert fit(regions, borders(regions, 0.9), Fitness(0, 0.1, 0), depth).max() == blocks
    assert fit(regions, borders(regions, 0.9), Fitness(0, 0.01, known), depth).max() == 2
    assert fit(regions, borders(regions, 0.9), Fitness(0, 0.01, known + 1), depth).max() == 1
    assert fit(regions, borders(regions, 0.9), Fitness(0, 0.0, 99), depth).max() == 2, "without a share none is needed"


def test_a_small_region_needs_no_more_known_pixels_than_it_has() -> None:
    regions = strips(10, 1, high=10)
    assert fit(regions, borders(regions, 0.9), Fitness(0, 0.05, 30)).max() == 2


def test_an_unfit_region_without_neighbours_is_a_block_unless_nothing_of_it_is_known() -> None:
    regions = np.array([[1, 1, 1, 0, 2, 0, 3]], np.int32).repeat(2, axis=0)
    depth = np.full(regions.shape, 2.0)
    depth[:, 6] = np.nan
    labels = fit(regions, np.zeros(regions.shape, np.float32), Fitness(5, 0.5, 30), depth)
    np.testing.assert_array_equal(labels, [[1, 1, 1, 0, 2, 0, 0]] * 2)


def test_a_region_of_which_nothing_is_known_is_no_block_where_none_must_be() -> None:
    regions = strips(4, 4)
    depth = np.where(regions == 1, 2.0, np.nan)
    np.testing.assert_array_equal(fit(regions, borders(regions, 0.1), ANY, depth), np.where(regions == 1, 1, 0))


def test_what_is_known_of_united_regions_adds_up() -> None:
    regions = strips(4, 4, 8)
    depth = np.where(regions == 2, 2.0, np.nan)
    depth[0, -1] = 2.0
    graph = RegionGraph(regions, borders(regions, 0.1, 0.9), frame_of(depth, regions.shape), None)
    graph.merge_below(0.5)
    assert sorted(graph.pixels[[1, 2]]) == [16, 32]
    graph.take_in_unfit(Fitness(0, 0.5, 0))
    np.testing.assert_array_equal(graph.labels(), np.ones_like(regions))


# numbers


def test_blocks_are_numbered_from_the_largest_down_and_zero_stays() -> None:
    labels = np.array([[0, 5, 5, 0], [2, 2, 2, 9]])
    np.testing.assert_array_equal(numbered(labels), [[0, 2, 2, 0], [1, 1, 1, 3]])
    assert numbered(labels).dtype == np.int32
    np.testing.assert_array_equal(numbered(np.array([[4, 4], [7, 7], [7, 3]])), [[2, 2], [1, 1], [1, 3]])
    np.testing.assert_array_equal(numbered(np.array([[8, 8, 3, 3]])), [[2, 2, 1, 1]], "as large: in their former order")

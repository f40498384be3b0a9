"""Suspect islands: a speck of wrong depth rules no hole, and what is true or sparse counts as before."""

import numpy as np
import pytest

import ilf
from ilf.completion.suspects import suspect_islands
from ilf.evaluation.quality.invalid_depth import suggest_invalid

HEIGHT, WIDTH = 240, 320
ROWS, COLUMNS = np.mgrid[:HEIGHT, :WIDTH]
HOLES = {"inside": (120, 160, 50), "left": (110, 0, 55), "corner": (239, 319, 70), "top": (0, 150, 45)}
"""Centres and radii of holes, in the frame and at its border."""


def table() -> np.ndarray:
    return 1 / (1.1 + 0.0015 * ROWS + 0.0003 * COLUMNS)


def disc(row: float, column: float, pixels: float) -> np.ndarray:
    return (ROWS - row) ** 2 + (COLUMNS - column) ** 2 <= pixels / np.pi


def frame_of(depth: np.ndarray) -> ilf.RGBDFrame:
    rng = np.random.default_rng(0)
    grain = rng.integers(-4, 5, (HEIGHT, WIDTH, 1))
    return ilf.RGBDFrame((120 + grain + np.zeros(3, int)).astype(np.uint8), depth)


def with_island(hole: str, pixels: int, depth: float, off: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """Depth of a table with an island in a hole, `off` of its radius from its centre; and the island."""
    row, column, radius = HOLES[hole]
    found = table()
    found[disc(row, column, np.pi * radius**2)] = np.nan
    at = np.clip(row + off * radius, 0, HEIGHT - 1), np.clip(column - off * radius, 0, WIDTH - 1)
    island = disc(*at, pixels)
    found[island] = depth
    return found, island


@pytest.mark.parametrize("hole", HOLES)
@pytest.mark.parametrize("pixels", [5, 38, 200])
@pytest.mark.parametrize("value", [12.0, 0.25])
def test_a_speck_does_not_rule_the_hole(hole, pixels, value):
    depth, island = with_island(hole, pixels, value)
    frame = frame_of(depth)
    assert np.array_equal(suspect_islands(frame), island)
    if pixels != 38:
        return
    done = ilf.complete(frame, np.ones(frame.shape, np.int32))
    filled = np.isnan(depth)
    assert np.abs(done.depth - table())[filled].max() < 0.05
    assert np.array_equal(done.depth[island], depth[island].astype(np.float32))  # it keeps its depth
    outcome = done.outcomes[1]
    assert (outcome.suspect, outcome.recovered) == (np.count_nonzero(island), np.count_nonzero(filled))
    assert "suspect" in outcome.message
    assert f"{outcome.suspect} suspect" in done.summary()
    assert (ilf.expected_error(done)[filled] < 0.3).all()
    assert suggest_invalid(frame, np.zeros(frame.shape, np.float32))[island].all()


def test_denoising_leaves_it_out_and_the_papers_presets_use_it():
    depth, island = with_island("inside", 38, 12.0)
    frame, blocks = frame_of(depth), np.ones((HEIGHT, WIDTH), np.int32)
    for parameters, left_out in (
        (ilf.preset(mode="fill+denoise"), True),
        (ilf.preset("paper", max_iterations=50), False),
    ):
        done = ilf.complete(frame, blocks, parameters)
        assert np.array_equal(done.depth[island], depth[island].astype(np.float32))
        assert (np.nanmax(np.where(island, 0, done.depth)) < 1.0) == left_out
        assert (done.outcomes[1].suspect > 0) == left_out


def test_extrapolation_leaves_it_out():
    depth, island = with_island("inside", 38, 12.0)
    done = ilf.complete(frame_of(depth), np.zeros((HEIGHT, WIDTH), np.int32), extrapolate=True)
    assert np.nanmax(np.where(island, 0, done.depth)) < 1.0


def test_a_block_of_nothing_else_keeps_it():
    depth, island = with_island("inside", 200, 3.0)
    blocks = np.ones((HEIGHT, WIDTH), np.int32)
    blocks[disc(*np.argwhere(island).mean(axis=0), 600)] = 2
    done = ilf.complete(frame_of(depth), blocks)
    assert done.outcomes[2].suspect == 0
    assert done.depth[blocks == 2].min() > 2.0


def in_front(kind: str) -> np.ndarray:
    """Depth of small things before a wall, with missing depth in their shadow and, 2 px wide, around them."""
    depth = 1 / (0.32 + 0.0002 * COLUMNS)
    things = {
        "ball": disc(120, 160, 180),
        "lamp": disc(60, 200, 120) | ((np.abs(COLUMNS - 200) < 2) & (ROWS < 60)),
        "pole": np.abs(COLUMNS - 100) < 3,
        "legs": (np.abs(COLUMNS % 60 - 30) < 2) & (ROWS > 190),
        "leaves": ((ROWS // 9 + COLUMNS // 9) % 2 == 0) & disc(120, 160, 8000),
    }[kind]
    shadow = np.zeros_like(things)
    for by in range(1, 13):
        shadow[:, :-by] |= things[:, by:]
    rim = np.zeros_like(things)
    for down in range(-2, 3):
        for along in range(-2, 3):
            rim |= np.roll(things, (down, along), (0, 1))
    depth[shadow | rim] = np.nan
    depth[things] = 1.0
    return depth


@pytest.mark.parametrize("kind", ["ball", "lamp", "pole", "legs", "leaves"])
def test_small_things_before_a_wall_are_used(kind):
    assert not suspect_islands(frame_of(in_front(kind))).any()


@pytest.mark.parametrize("kind", ["points", "lines", "thin lines", "scattered"])
def test_in_sparse_depth_islands_are_the_data(kind):
    depth = np.where(in_front("ball") == 1.0, 1.0, 3.0)
    rng = np.random.default_rng(1)
    kept = {
        "points": rng.permutation(depth.size).reshape(depth.shape) < 500,
        "lines": ROWS % 16 == 8,
        "thin lines": ROWS % 4 == 1,
        "scattered": rng.random(depth.shape) < 0.4,
    }[kind]
    assert not suspect_islands(frame_of(np.where(kept, depth, np.nan))).any()


def test_what_other_depth_near_by_supports_is_used():
    """The floor seen beside a table, between wide holes."""
    depth, _ = with_island("inside", 200, 3.0)
    depth[:60, :] = 3.2
    assert not suspect_islands(frame_of(depth)).any()

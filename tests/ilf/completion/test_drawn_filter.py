"""Drawn borders in the filter: no depth gets across, each block sees its own, and without any all is as before."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

import ilf
from ilf.completion.edge_aware.grid import CutLinks
from ilf.errors import InputError

SHAPE = (120, 160)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
HOLE = (ROWS >= 30) & (ROWS < 90) & (COLUMNS >= 40) & (COLUMNS < 120)
LABELS = np.where(COLUMNS - 12 * np.sin(ROWS / 7) < 80, 1, 2).astype(np.int32)
"""Two blocks; their border winds through the hole."""


def _grey(depth, hole=HOLE):
    """A frame whose colour says nothing, with a hole in its depth."""
    return ilf.RGBDFrame(np.full((*depth.shape, 3), 128, np.uint8), np.where(hole, np.nan, depth))


def _border(labels):
    """All pixels with a neighbour of another label."""
    found = np.zeros(labels.shape, bool)
    for values, at in ((labels, found), (labels.T, found.T)):
        other = values[1:] != values[:-1]
        at[1:] |= other
        at[:-1] |= other
    return found


STEP = np.where(LABELS == 1, 1.0, 2.0)
PLANES = np.where(LABELS == 1, 1 + 0.001 * ROWS + 0.002 * COLUMNS, 2 + 0.003 * COLUMNS - 0.002 * ROWS)


@pytest.mark.parametrize("ground_truth", [STEP, PLANES], ids=["constant", "planes"])
@pytest.mark.parametrize("changes", [{}, {"jump_share": 0.0}, {"mode": "fill+denoise"}])
def test_no_depth_gets_across_a_drawn_border(ground_truth, changes):
    frame, parameters = _grey(ground_truth), ilf.preset("best", **changes)
    off = {
        name: np.abs(ilf.complete(frame, LABELS, parameters, drawn=drawn).depth - ground_truth)[HOLE]
        for name, drawn in (("drawn", _border(LABELS)), ("extracted", None))
    }
    assert off["drawn"].max() < 0.001
    # constant depth limits a block, and in the mode, polynomials explain it: neither needs depth from beyond a border
    if "mode" not in changes and ground_truth is PLANES:
        assert off["extracted"].mean() > 0.03


def test_a_blocks_result_depends_on_drawn_pixels_of_its_own_border_alone():
    frame, border = _grey(PLANES), _border(LABELS)
    drawn = (border, border & (LABELS == 1), None, ~border)
    every, first, none, inner = (ilf.complete(frame, LABELS, ilf.preset(correction=False), drawn=one) for one in drawn)
    for label, same_as in ((1, every), (2, none)):
        assert np.array_equal(first.results[label].depth, same_as.results[label].depth)
        assert np.array_equal(inner.results[label].depth, none.results[label].depth)
    assert not np.array_equal(every.depth, none.depth)


def test_steps_show_the_same_surface_as_the_completion():
    frame, drawn = _grey(PLANES), _border(LABELS)
    stepper = ilf.iterate(frame, ilf.Blocks(LABELS, drawn=drawn), 1)
    coarse = [np.abs(stepper.surface - PLANES[LABELS == 1]).max() for _ in stepper]
    assert max(coarse) < 0.1, "no depth gets across on the coarser grids either"
    result = ilf.complete(frame, LABELS, drawn=drawn, threads=2).results[1].depth
    assert np.array_equal(result[HOLE[LABELS == 1]], stepper.surface.astype(np.float32)[HOLE[LABELS == 1]])


@pytest.mark.parametrize("name", ["best", "paper", "released-code"])
def test_without_drawn_borders_nothing_changes_and_the_pass_band_knows_none(name):
    frame, parameters = _grey(PLANES), ilf.preset(name, max_iterations=40)
    none = ilf.complete(frame, LABELS, parameters).depth
    assert np.array_equal(ilf.complete(frame, LABELS, parameters, drawn=np.zeros(SHAPE, bool)).depth, none)
    drawn = ilf.complete(frame, LABELS, parameters, drawn=_border(LABELS)).depth
    assert np.array_equal(drawn, none) == (name != "best")


@pytest.mark.parametrize("drawn", [np.zeros(SHAPE), np.zeros((3, 4), bool)])
def test_a_mask_that_does_not_fit_is_refused(drawn):
    with pytest.raises(InputError, match=r"drawn borders must be bool with the frame's shape \(120, 160\)"):
        ilf.complete(_grey(STEP), LABELS, drawn=drawn)


masks = array_shapes(min_dims=2, max_dims=2, max_side=12).flatmap(lambda shape: arrays(np.bool_, shape))


@given(st.integers(2, 30), st.integers(2, 40), st.integers(0, 9999), st.booleans())
@settings(max_examples=25)
def test_of_any_blocks_those_drawn_all_round_keep_their_own_depth(height, width, seed, denoise):
    """Blocks in crumbs, some without known depth anywhere near: nothing is too odd."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 4, (height // 4 + 1, width // 4 + 1))
    labels = coarse.repeat(4, 0).repeat(4, 1)[:height, :width].astype(np.int32)
    labels[rng.random(labels.shape) < 0.05] = 1
    drawn = _border(labels) & (labels > 0) & (rng.random(labels.shape) < rng.choice([0.5, 1.0]))
    ground_truth = 1.0 + labels.astype(float)
    known = rng.random(labels.shape) < rng.choice([0.1, 0.6])
    known[0, 0] = True
    mode = "fill+denoise" if denoise else "fill"
    parameters = ilf.preset(mode=mode, min_known_share=0.0, min_known_pixels=1)
    result = ilf.complete(_grey(ground_truth, ~known), labels, parameters, drawn=drawn, threads=1)
    for label, of_block in result.results.items():
        assert of_block.depth.shape == (np.count_nonzero(labels == label),)
        closed = not (_border(labels) & (labels == label) & ~drawn).any()
        if closed and of_block.outcome.iterations:
            assert np.allclose(of_block.depth, 1 + label, atol=0.01)


@given(masks)
def test_a_border_that_is_drawn_all_round_parts_on_every_grid(inside):
    """No link leads out, no cell that stands for the block holds anything else, and a surface is enlarged apart."""
    level = CutLinks.around(inside, inside)
    while level is not None and level.inside.size > 1:
        shape = level.inside.shape
        assert not (level.right[:, :-1] & (level.inside[:, 1:] != level.inside[:, :-1])).any()
        assert not (level.down[:-1] & (level.inside[1:] != level.inside[:-1])).any()
        coarser = level.halved()
        own = coarser.inside.repeat(2, 0).repeat(2, 1)[: shape[0], : shape[1]] == level.inside
        assert np.array_equal(level.kept, own)
        enlarged = coarser.enlarged(np.where(coarser.inside, 1, 2).astype(np.float32), level)
        assert np.allclose(enlarged[own], np.where(level.inside, 1, 2)[own], atol=1e-6)
        level = coarser


@given(masks, st.randoms(use_true_random=False))
def test_cuts_go_from_the_drawn_pixels_out_of_the_block(inside, random):
    drawn = np.array([[random.random() < 0.5 for _ in row] for row in inside])
    level, height, width = CutLinks.around(inside, drawn), *inside.shape
    cuts = 0
    for row, column in np.ndindex(inside.shape):
        for there, along in (((row, column + 1), "right"), ((row + 1, column), "down")):
            parted = False
            if there[0] < height and there[1] < width:
                own = [place for place in ((row, column), there) if inside[place]]
                parted = len(own) == 1 and bool(drawn[own[0]])
            cuts += parted
            assert level is None or getattr(level, along)[row, column] == (not parted)
    assert (level is None) == (cuts == 0)

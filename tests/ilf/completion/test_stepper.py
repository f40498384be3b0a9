"""What every filter promises: the contract that `Stepper` writes down, and the records."""

import itertools
import math
import threading

import numpy as np
import pytest

import ilf
from ilf.completion.block import max_pixels
from ilf.data.blocks import find_blocks
from ilf.data.results import EdgeAwareRecord, PassBandRecord, Status

RECORDS = {"ideal": PassBandRecord, "edge-aware": EdgeAwareRecord}


@pytest.fixture(params=[*ilf.PRESETS, "held out", "cut short"])
def parameters(request):
    others = {
        "held out": ilf.preset(validation_share=0.2, mode="fill+denoise"),
        "cut short": ilf.preset("paper", max_iterations=4),
    }
    return others.get(request.param) or ilf.preset(request.param, max_iterations=200)


@pytest.fixture
def steps(small_frame, small_labels, parameters):
    return ilf.iterate(small_frame, small_labels, 1, parameters)


def test_every_iteration_gives_a_record(steps, parameters):
    assert iter(steps) is steps
    assert not steps.settled
    records = list(steps)
    assert {type(record) for record in records} == {RECORDS[parameters.filter]}
    assert [record.i for record in records] == list(range(1, len(records) + 1))
    assert len(records) <= parameters.max_iterations
    assert records[0].stage == 1
    for before, after in itertools.pairwise(records):
        assert after.stage - before.stage in (0, 1)
        assert after.seconds >= before.seconds
    assert all(math.isnan(record.held_out) == (parameters.validation_share == 0) for record in records)
    assert all(record.residual >= 0 and record.sigma_i >= 0 for record in records)
    with pytest.raises(StopIteration):
        next(steps)
    assert steps.settled == (parameters.max_iterations > 4)


def test_the_size_foretold_is_of_the_blocks_box_up_to_the_frame(small_frame, small_labels, parameters):
    small_labels[:40] = 0
    block = find_blocks(small_labels)[1]
    foretold = max_pixels(small_frame, block, parameters)
    assert block.mask.size <= foretold < small_frame.depth.size


def test_the_surface_is_there_at_any_time_and_the_callers_own(steps, small_frame, parameters):
    pixels = 48 * 30
    for _ in range(4):
        surface = steps.surface
        assert surface.dtype == np.float64
        assert surface.shape == (pixels,)
        assert np.isfinite(surface).all()
        surface[:] = -1
        assert (steps.surface != -1).all()
        next(steps)
    for record in steps:
        assert record.l1 == pytest.approx(np.abs(steps.surface).sum(), rel=1e-3)


def test_the_surface_may_be_looked_at_from_another_thread(small_frame, small_labels, parameters, steps):
    alone = ilf.iterate(small_frame, small_labels, 1, parameters)
    expected = {steps.surface.tobytes()} | {alone.surface.tobytes() for _ in alone}
    seen, done = set(), threading.Event()

    def look():
        while not done.is_set():
            seen.add(steps.surface.tobytes())

    onlooker = threading.Thread(target=look)
    onlooker.start()
    try:
        list(steps)
    finally:
        done.set()
        onlooker.join()
    assert seen
    assert seen <= expected


def test_a_snapshot_has_the_surface_where_depth_is_missing_if_the_gap_goes_on_in_another_block(
    small_frame, small_labels, parameters
):
    small_labels[:, 14:] = 2  # through the middle of the left gap
    block = find_blocks(small_labels)[1]
    steps = ilf.iterate(small_frame, small_labels, 1, parameters)
    missing = np.isnan(small_frame.depth[block.box][block.mask])
    for _ in range(4):
        assert np.allclose(steps.snapshot().surface()[missing], steps.surface[missing], rtol=0, atol=1e-5)
        next(steps)


def test_a_remark_is_made_where_the_last_stage_was_not_steady(small_frame, small_labels):
    for parameters in (ilf.preset(), ilf.preset("paper"), ilf.preset("released-code", max_iterations=5)):
        steps = ilf.iterate(small_frame, small_labels, 1, parameters)
        *_, _ = steps
        assert (steps.settled, steps.remark) == (True, "")
    strict = ilf.iterate(small_frame, small_labels, 1, ilf.preset(s_criteria=0.0))
    *_, _ = strict
    assert strict.settled
    assert "limit of steps" in strict.remark
    outcome = ilf.complete(small_frame, small_labels, ilf.preset(s_criteria=0.0)).outcomes[1]
    assert (outcome.status, outcome.message) == (Status.ITERATION_LIMIT, strict.remark)

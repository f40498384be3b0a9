"""Errors against a truth, against hidden depth, and over values of parameters."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import ilf
from ilf._runtime.long_work import run_to_end
from ilf.errors import InputError, ParameterError
from ilf.evaluation.bench.runner import sparsification_error
from ilf.evaluation.evaluation import Evaluation, Progress, evaluate, evaluate_blocks, share_within
from ilf.evaluation.hold_out import compared_steps, hidden_pixels, hold_out_steps
from ilf.evaluation.sweep import Sweep, SweepPoint, run_sweep

QUICK = ilf.preset("paper", max_iterations=30)


@pytest.fixture
def planes(small_frame):
    """The two planes with their truth."""
    rows, columns = np.mgrid[:48, :64]
    return small_frame.with_ground_truth(np.where(columns < 30, 1.5 + 0.004 * rows, 2.4 + 0.005 * columns))


@pytest.fixture
def run(planes, small_labels):
    return ilf.Run(planes, small_labels, QUICK)


def test_judgement_by_hand():
    """Errors 0, 1, -1, 2; ratios 1, 1.5, 4/3, 2; the last three pixels have no depth or no ground truth."""
    depth = np.array([[1.0, 3.0, 3.0, 4.0, np.nan, -1.0, 1.0]])
    ground_truth = np.array([[1.0, 2.0, 4.0, 2.0, 9.0, 9.0, np.nan]])
    found = evaluate(depth, ground_truth, expected=np.full((1, 7), 1.0))
    assert found.pixels == 4
    assert found.rmse == pytest.approx(np.sqrt(6 / 4))
    assert found.mae == found.median == pytest.approx(1.0)
    assert found.rel == pytest.approx((0 + 1 / 2 + 1 / 4 + 1) / 4)
    assert found.delta == (0.25, 0.75, 0.75)
    assert found.bias == pytest.approx(0.5)
    assert found.deviation == pytest.approx(np.sqrt(6 / 4 - 0.5**2))
    assert found.within == 0.75
    assert evaluate(depth, ground_truth, depth < 3).pixels == 1
    assert evaluate(depth, ground_truth, np.zeros((1, 7), bool)) == Evaluation()
    assert evaluate(depth, ground_truth, expected=np.full((1, 7), np.nan)).within is None
    with pytest.raises(InputError, match=r"truth \(7,\)"):
        evaluate(depth, ground_truth[0])


def test_the_order_of_expected_errors_is_judged_by_leaving_pixels_out():
    rng = np.random.default_rng(3)
    error, expected = rng.normal(0, 0.1, 40), rng.permutation(np.linspace(0.01, 0.2, 40))
    assert share_within(error, expected, 2) == np.mean([abs(e) <= 2 * x for e, x in zip(error, expected, strict=True)])

    def curve(order):
        return [np.sqrt(np.mean(error[order[left:]] ** 2)) for left in range(40)]

    area = np.mean(np.subtract(curve(np.argsort(-expected)), curve(np.argsort(-abs(error)))))
    assert sparsification_error(error, expected) == pytest.approx(area / np.sqrt(np.mean(error**2)))
    assert sparsification_error(error, 7 * abs(error)) == 0
    assert sparsification_error(np.zeros(3), np.ones(3)) == 0
    # the order in which equals come says nothing
    assert sparsification_error(error, np.ones(40)) == pytest.approx(sparsification_error(error[::-1], np.ones(40)))


def test_frame_blocks_and_box_are_judged_over_their_filled_pixels(run):
    frame, completion = run.frame, run.complete()
    expected = ilf.expected_error(completion)
    whole = ilf.evaluate_completion(frame, completion, expected=expected)
    assert whole == evaluate(completion.depth, frame.ground_truth, completion.filled, expected)
    assert 0 <= whole.within <= 1
    blocks = evaluate_blocks(frame, completion, run.blocks.labels)
    for label in (1, 2):
        assert blocks[label] == ilf.evaluate_completion(frame, completion, run.blocks.labels == label)
    box = slice(8, 20), slice(4, 16)
    assert ilf.evaluate_completion(frame, completion, box).pixels == np.count_nonzero(completion.filled[box])
    every = ilf.evaluate_completion(frame, completion, every=True)
    assert every.pixels == frame.depth.size
    assert every.median == 0
    assert evaluate_blocks(frame, completion, np.zeros_like(run.blocks.labels)) == {}
    with pytest.raises(InputError, match="no ground truth"):
        ilf.evaluate_completion(frame.with_ground_truth(None), completion)


@pytest.mark.parametrize("pattern", ["areas", "random"])
def test_the_same_depth_is_hidden_whatever_else_changes(pattern, planes):
    test = ilf.HoldOutTest(pattern, (3,))
    hidden = test.hidden(planes, 3)
    assert not (hidden & ~planes.known).any()
    assert 0.2 < hidden.sum() / planes.known.sum() < 0.6
    mask = np.zeros(planes.shape, bool)
    mask[:10] = True
    np.testing.assert_array_equal(hidden, test.hidden(planes.with_invalid_mask(mask).with_ground_truth(None), 3))
    assert (hidden != test.hidden(planes, 4)).any()
    assert (hidden != test.hidden(replace(planes, name="other"), 3)).any()


@pytest.mark.parametrize("parameters", [QUICK, ilf.preset("best")], ids=["paper", "best"])
def test_the_hidden_depth_reaches_no_filter(parameters, run):
    test = ilf.HoldOutTest("areas", (0,))
    hidden = test.hidden(run.frame, 0)
    lied = ilf.RGBDFrame(run.frame.rgb, np.where(hidden, run.frame.depth + 1.5, run.frame.depth), name=run.frame.name)
    honest, other = (
        ilf.evaluate_hold_out(replace(run, frame=frame, parameters=parameters), test) for frame in (run.frame, lied)
    )
    np.testing.assert_array_equal(honest.parts[0].depth, other.parts[0].depth)
    assert other.whole.bias == pytest.approx(honest.whole.bias - 1.5, abs=1e-5)


def test_errors_on_hidden_depth_are_pooled_over_seeds_and_told_by_block(run):
    result = ilf.evaluate_hold_out(run, ilf.HoldOutTest("areas", (0, 1)))
    parts = [ilf.evaluate_hold_out(run, ilf.HoldOutTest("areas", (seed,))).whole for seed in (0, 1)]
    sizes, squares = zip(*((part.pixels, part.pixels * part.rmse**2) for part in parts), strict=True)
    assert result.whole.pixels == sum(sizes)
    assert result.whole.rmse == pytest.approx(np.sqrt(sum(squares) / sum(sizes)))
    assert sum(evaluation.pixels for evaluation in result.blocks.values()) == result.whole.pixels
    assert result.pixels == sum(int(result.test.hidden(run.frame, seed).sum()) for seed in (0, 1))
    assert result.coverage == pytest.approx(result.whole.pixels / result.pixels)
    alone = ilf.evaluate_hold_out(run, ilf.HoldOutTest("areas", (0, 1)), only=[2])
    # the expected error at its border goes by what is filled beyond
    assert alone.blocks == {2: replace(result.blocks[2], within=alone.blocks[2].within)}


def test_a_camera_is_doubted_once(run):
    with pytest.warns(ilf.DepthWarning, match="principal point"):
        doubted = run.frame.changed(intrinsics=(60, 60, 5, 5))
    ilf.evaluate_hold_out(replace(run, frame=doubted))


def test_runs_are_compared_on_what_both_fill(run):
    test = ilf.HoldOutTest("areas", (0,))
    # of block 2, whose known depth is too little for it, nothing comes back
    refusing = run.with_parameters(QUICK, {2: QUICK.replace(min_known_share=1.0)})
    other = replace(run, parameters=ilf.preset("best"))
    several = [hold_out_steps(one, test) for one in (run, other, refusing)]
    steps: list[Progress] = []
    first, second, third = run_to_end(compared_steps(several), steps.append)
    assert first.whole.pixels == second.whole.pixels == first.pixels
    assert first.whole == ilf.evaluate_hold_out(run, test).whole
    assert third.coverage < 0.9
    assert set(third.blocks) == {1, 2}
    assert third.blocks[2].pixels == 0
    assert steps[-1].share == pytest.approx(1)
    assert all(one.share <= two.share + 1e-9 for one, two in pairwise(steps))


def test_depth_that_is_distrusted_in_one_run_is_compared_in_none(run):
    mask = np.zeros(run.frame.shape, bool)
    mask[:, :30] = True
    test = ilf.HoldOutTest("random", (0,))
    runs = [run, replace(run, frame=run.frame.with_invalid_mask(mask))]
    trusting, doubting = run_to_end(compared_steps([hold_out_steps(one, test) for one in runs]))
    assert trusting.whole.pixels == doubting.whole.pixels == doubting.pixels < trusting.pixels
    assert not mask.ravel()[doubting.parts[0].places].any()


def test_bad_tests_are_refused(planes):
    with pytest.raises(ParameterError, match="no pattern 'stripes'"):
        ilf.HoldOutTest("stripes")
    with pytest.raises(ParameterError, match="needs seeds"):
        ilf.HoldOutTest(seeds=())
    with pytest.raises(ParameterError, match="from 0 on"):
        ilf.HoldOutTest(seeds=(-1,))
    with pytest.raises(InputError, match="no pattern"):
        hidden_pixels(planes, "ground_truth")
    one = np.zeros((40, 60))
    one[3, 4] = 2
    frame = ilf.RGBDFrame(np.zeros((40, 60, 3), np.uint8), one)
    with pytest.raises(InputError, match="all of it would be hidden"):
        ilf.evaluate_hold_out(ilf.Run(frame, np.ones((40, 60), np.int32)), ilf.HoldOutTest("random", (0,)))


def test_a_sweep_of_two_on_hidden_depth_for_one_blocks_own_values(run):
    own = QUICK.replace(max_iterations=5)
    values = {"shortest_wavelength": [100, 15], "centred": [False, True]}
    sweep = Sweep(run.with_parameters(QUICK, {2: own}), values, ilf.HoldOutTest("random", (0,)), only=[2])
    items: list[Progress | SweepPoint] = []
    result = run_sweep(sweep, on_step=items.append)
    shares = [item.share for item in items if isinstance(item, Progress)]
    assert shares[0] == 0
    assert shares[-1] == pytest.approx(1)
    assert all(one <= two + 1e-9 for one, two in pairwise(shares))
    assert [tuple(point.values.values()) for point in result.points] == [
        (100.0, False), (100.0, True), (15.0, False), (15.0, True),
    ]  # fmt: skip
    best = result.best
    assert best.run.parameters_of(2) == own.replace(**best.values)
    assert best.run.parameters == QUICK, "the common values are as they were"
    assert best.values["centred"], "nothing is to be lifted from 0 m"
    assert set(best.blocks) == {2}
    assert np.isnan(best.depth[:, :30][np.isnan(run.frame.depth[:, :30])]).all(), "block 1 was not run"


def test_a_value_that_refuses_to_fill_is_never_the_best(run):
    result = run_sweep(Sweep(run, {"min_known_share": [0.02, 1.0]}))
    assert result.best is result.points[0]
    assert result.points[1].coverage == 0
    assert result.points[1].whole == Evaluation()
    nothing = run_sweep(Sweep(run, {"min_known_share": [1.0]}))
    assert nothing.best is None


def test_bad_sweeps_are_refused_before_anything_is_run(run):
    with pytest.raises(ParameterError, match="Did you mean padding"):
        Sweep(run, {"paddin": [1]})
    with pytest.raises(ParameterError, match="padding must lie between 1 and 4 x, not 9"):
        Sweep(run, {"padding": [2, 9]})
    with pytest.raises(ParameterError, match="smoothness has no effect with filter ideal"):
        Sweep(run, {"smoothness": [2, 3]})
    assert len(Sweep(run, {"filter": ["ideal", "edge-aware"], "smoothness": [2, 3]}).points) == 4
    with pytest.raises(ParameterError, match="400 points needs too much memory"):
        Sweep(run, {"padding": np.linspace(1, 4, 20).tolist(), "max_iterations": list(range(1, 21))})
    for values in ({}, {"padding": []}, {"padding": [1], "centred": [True], "staged_start": [1]}):
        with pytest.raises(ParameterError, match="one or two parameters"):
            Sweep(run, values)
    for only in ([9], []):
        with pytest.raises(InputError, match="no such blocks"):
            Sweep(run, {"padding": [2]}, only=only)
    bare = replace(run, frame=run.frame.with_ground_truth(None))
    with pytest.raises(InputError, match="no ground truth where depth is missing"):
        Sweep(bare, {"padding": [2]})

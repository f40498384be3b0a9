"""What a completion promises: known pixels, refusals, composition, cancelling."""

import dataclasses
import os
import re
import subprocess
import sys
import threading
import time

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest

import ilf
from ilf._runtime.formatting import counted
from ilf._runtime.long_work import run_in_parallel
from ilf.completion.block import BlockTask, required_known_pixels
from ilf.completion.pass_band.iteration import PassBandIteration
from ilf.data.results import Status, compose
from ilf.drawing.blocks import block_overlay
from ilf.errors import InputError, ParameterError

from .blas_bits import bits


@pytest.mark.parametrize("name", ["best", "paper"])
def test_fill_mode_leaves_every_known_pixel_untouched(name, small_frame, small_labels):
    result = ilf.complete(small_frame, small_labels, ilf.preset(name))
    known = small_frame.known
    assert np.array_equal(result.depth[known], small_frame.depth[known])
    assert np.isfinite(result.depth).all()
    assert np.array_equal(result.filled, ~known)
    assert result.depth.dtype == np.float32


def test_the_first_call_extracts_blocks_and_completes_by_best(small_frame):
    blocks = ilf.extract_blocks(small_frame)
    wanted = ilf.complete(small_frame, blocks, ilf.preset("best"))
    found = ilf.complete(small_frame)
    np.testing.assert_array_equal(found.depth, wanted.depth)
    for completion in (found, wanted):
        np.testing.assert_array_equal(completion.blocks, blocks)
        assert completion.frame is small_frame
    assert found.run.blocks.extraction == ilf.BlockParameters()
    assert not found.run.blocks.edited
    assert wanted.run.blocks.edited, "nobody knows what given blocks were extracted with"


def test_parameters_of_filter_and_extraction_are_given_by_keyword(small_frame):
    extraction = ilf.BlockParameters(granularity=0.9)
    blocks = ilf.Blocks(ilf.extract_blocks(small_frame, extraction), extraction=extraction)
    wanted = ilf.Run(small_frame, blocks, ilf.preset("paper", max_iterations=20, min_known_share=0.5))
    found = ilf.complete(small_frame, preset="paper", max_iterations=20, min_known_share=0.5, granularity=0.9).run
    assert (found.parameters, found.blocks.extraction) == (wanted.parameters, extraction)
    np.testing.assert_array_equal(found.blocks, wanted.blocks)
    quick = ilf.preset("paper", max_iterations=3)
    assert len(list(ilf.iterate(small_frame, found.blocks, 1, "paper", max_iterations=3))) == 3
    assert ilf.complete(small_frame, found.blocks, quick, rgb_iterations=0).run.parameters == quick.replace(
        rgb_iterations=0
    )
    for wrong, message in (
        ({"nois": 0.1}, "no parameter 'nois'. Did you mean noise?"),
        ({"granularty": 0.1}, "Did you mean granularity?"),
        ({"thread": 2}, "Did you mean threads?"),
        ({"padding": 2}, "padding has no effect with filter edge-aware"),
        ({"noise": 7}, "noise must lie between 0 and 1 m, not 7"),
        ({"blocks": found.blocks, "granularity": 0.1}, "granularity would have no effect, because blocks are given"),
    ):
        with pytest.raises(ParameterError, match=re.escape(message)):
            ilf.complete(small_frame, **wrong)
    with pytest.raises(ParameterError, match=r"no parameter 'max_iteration'\. Did you mean max_iterations\?"):
        ilf.iterate(small_frame, found.blocks, 1, max_iteration=3)


def test_a_mask_is_one_block(small_frame, small_labels):
    wanted = ilf.complete(small_frame, (small_labels == 2).astype(np.int32), max_iterations=5)
    masked = ilf.complete(small_frame, small_labels == 2, max_iterations=5)
    np.testing.assert_array_equal(masked.depth, wanted.depth)
    assert masked.blocks.dtype == np.int32


def test_a_completion_is_a_line_of_text_and_pictures(small_frame, small_labels):
    completion = ilf.complete(small_frame, small_labels == 1)
    left = np.count_nonzero(np.isnan(completion.depth))
    filled = np.count_nonzero(completion.filled)
    assert repr(completion) == (
        f"<Completion of {small_frame.name!r}: 64 x 48 pixels, 1 block, {filled} pixels filled, {left} still missing>"
    )
    assert f" pixels filled ({left} extrapolated), 0 still missing>" in repr(ilf.extrapolate(completion))
    assert repr(compose(completion.run, completion.results)).startswith("<Completion of ")
    assert completion._repr_html_().count("data:image/png;base64,") == 3
    matplotlib.use("agg")
    axes = completion.plot()
    assert [axis.get_title() for axis in axes] == ["Colour", "Depth", "Completed depth"]
    matplotlib.pyplot.close(axes[0].figure)
    np.testing.assert_array_equal(np.asarray(completion.to_open3d().depth), np.nan_to_num(completion.depth))


def test_curves_error_and_blocks_are_plotted(small_frame, small_labels):
    matplotlib.use("agg")
    completion = ilf.complete(small_frame, small_labels)
    sigma, l1 = completion.plot_curves([1])
    records = completion.history[1]
    np.testing.assert_allclose(sigma.lines[0].get_ydata(), [1000 * record.sigma_i for record in records])
    shares = [100 * (record.l1 / records[-1].l1 - 1) for record in records]
    np.testing.assert_allclose(l1.lines[0].get_ydata(), shares)
    assert shares[0] != 0
    assert [text.get_text() for text in sigma.get_legend().get_texts()] == ["Block 1"]
    iterated = sum(bool(records) for records in completion.history.values())
    assert len(completion.plot_curves()[1].lines) == iterated > 1
    with pytest.raises(ilf.IlfError, match="no block 99"):
        completion.plot_curves([99])

    error = completion.plot_error()[1].images[0].get_array()
    np.testing.assert_allclose(np.ma.filled(error, np.nan), 1000 * ilf.expected_error(completion))

    run = completion.run
    assert repr(run) == f"<Run of {small_frame.name!r}: 64 x 48 pixels, {len(completion.results)} blocks, best>"
    assert run._repr_html_().count("data:image/png;base64,") == 3
    blocks = run.plot()[1].images[0].get_array()
    np.testing.assert_array_equal(blocks, block_overlay(small_frame.rgb, small_labels))
    assert (blocks != small_frame.rgb)[small_labels > 0].any(axis=-1).mean() > 0.9
    matplotlib.pyplot.close("all")


@pytest.mark.parametrize("given", ["nope", 7, ilf.BlockParameters()])
def test_what_are_no_parameters_is_refused(small_frame, small_labels, given):
    for call in (
        lambda: ilf.complete(small_frame, small_labels, given),
        lambda: ilf.complete(small_frame, small_labels, own={1: given, 2: "paper"}),
        lambda: ilf.iterate(small_frame, small_labels, 1, given),
        lambda: ilf.Run(small_frame, small_labels, given),
    ):
        with pytest.raises(ParameterError, match="best, paper, released-code"):
            call()
    with pytest.raises(ParameterError, match="preset="):
        ilf.complete(small_frame, extraction="paper")
    with pytest.raises(ParameterError, match=r"label map of the blocks, not 'paper': .*preset="):
        ilf.complete(small_frame, "paper")


@pytest.mark.parametrize("given", [np.zeros((48, 64, 3), np.uint8), "rgb.png", None])
def test_anything_but_a_frame_is_refused_with_what_to_give(given, small_labels):
    for call in (
        lambda: ilf.complete(given, small_labels),
        lambda: ilf.complete(given, small_labels, guide=np.ones((48, 64))),
        lambda: ilf.iterate(given, small_labels, 1),
        lambda: ilf.extract_blocks(given),
        lambda: ilf.Run(given, small_labels),
        lambda: ilf.Run.of(given),
        lambda: ilf.edge_strength(given),
    ):
        with pytest.raises(InputError, match="RGBDFrame"):
            call()


def test_fill_and_denoise_changes_the_whole_block(small_frame, small_labels):
    parameters = ilf.preset("paper", mode="fill+denoise")
    result = ilf.complete(small_frame, small_labels, parameters)
    stepper = ilf.iterate(small_frame, small_labels, 1, parameters)
    list(stepper)
    assert np.array_equal(result.depth[small_labels == 1], stepper.surface.astype(np.float32))
    known = small_frame.known
    assert (result.depth[known] != small_frame.depth[known]).mean() > 0.9
    assert np.array_equal(result.filled, ~known)


def test_blocks_without_enough_depth_are_reported_and_stay_missing(small_frame):
    depth = small_frame.depth.copy()
    depth[:, 30:] = np.nan
    depth[5, 40] = 2.0
    labels = np.ones(depth.shape, np.int32)
    labels[:, 30:] = 7
    result = ilf.complete(ilf.RGBDFrame(small_frame.rgb, depth), labels)
    outcome = result.outcomes[7]
    assert outcome.status is Status.NOT_RECOVERABLE
    assert outcome.message == (
        "1 of 1,632 pixels have depth (0.1%); at least 33 are needed. "
        "Merge it with a neighbour on the same surface, give it depth by hand, or lower the limits under Data."
    )
    assert (outcome.pixels, outcome.known, outcome.recovered) == (1632, 1, 0)
    assert outcome.defect_rate == 1631 / 1632
    assert outcome.iterations == 0
    assert np.count_nonzero(np.isfinite(result.depth[labels == 7])) == 1
    assert not result.filled[labels == 7].any()


@pytest.mark.parametrize(
    ("pixels", "share", "least", "needed"),
    [(1000, 0.02, 30, 30), (1000, 0.0301, 30, 31), (1000, 0.5, 30, 500), (20, 0.02, 30, 20), (30, 1.0, 31, 30)],
)
def test_known_pixels_that_a_block_needs(pixels, share, least, needed):
    parameters = ilf.preset(min_known_share=share, min_known_pixels=least)
    assert required_known_pixels(pixels, parameters) == needed
    assert required_known_pixels([pixels, 10_000], parameters).tolist() == [needed, max(10_000 * share, least)]


@pytest.mark.parametrize("size", [(1, 1), (1, 5), (2, 1)])
def test_tiny_blocks_do_no_harm(small_frame, size):
    labels = np.zeros(small_frame.shape, np.int32)
    labels[10 : 10 + size[0], 8 : 8 + size[1]] = 1  # inside the hole
    labels[2 : 2 + size[0], 2 : 2 + size[1]] = 2  # known
    parameters = ilf.preset(mode="fill+denoise", min_known_pixels=1)
    result = ilf.complete(small_frame, labels, parameters)
    assert result.outcomes[1].status is Status.NOT_RECOVERABLE
    assert result.outcomes[2].status in (Status.COMPLETED, Status.ITERATION_LIMIT)
    assert np.isfinite(result.depth[labels == 2]).all()


def test_running_some_blocks_composes_to_the_same_as_all(small_frame, small_labels):
    everything = ilf.complete(small_frame, small_labels)
    results = {}
    for label in (2, 1):
        results |= ilf.Run(small_frame, small_labels, only={label}).complete().results
    assert np.array_equal(compose(everything.run, results).depth, everything.depth)


@pytest.mark.parametrize("threads", [1, 2])
def test_cancelling_by_exception(small_frame, small_labels, threads):
    def stop(progress):
        if progress.record is not None and progress.record.i == 3:
            raise ilf.Cancelled("enough")

    with pytest.raises(ilf.Cancelled):
        ilf.complete(small_frame, small_labels, on_progress=stop, threads=threads)


@pytest.fixture
def patchwork(small_frame):
    """Twelve blocks of different sizes, one of them without depth, one with all of it."""
    rows = np.searchsorted([9, 25], np.arange(48), side="right")
    columns = np.searchsorted([7, 20, 44], np.arange(64), side="right")
    depth = small_frame.depth.copy()
    depth[:9, :7] = np.nan
    depth[25:, 44:] = np.where(np.indices((23, 20)).sum(axis=0) % 3 == 0, np.nan, 2.0)
    labels = 1 + 4 * rows[:, None] + columns[None, :]
    return ilf.RGBDFrame(small_frame.rgb, depth), labels.astype(np.int32)


@pytest.mark.parametrize("threads", [3, 20])
def test_results_do_not_depend_on_the_number_of_threads(patchwork, monkeypatch, threads):
    monkeypatch.setattr("ilf._runtime.long_work.SLICE_S", 0.0005)
    frame, labels = patchwork
    parameters = ilf.preset(max_iterations=60, mode="fill+denoise")
    alone = ilf.complete(frame, labels, parameters, threads=1)
    seen = {}

    def note(progress):
        if progress.record is not None:
            seen.setdefault(progress.label, []).append(progress.record.i)

    together = ilf.complete(frame, labels, parameters, on_progress=note, threads=threads)
    assert together.depth.tobytes() == alone.depth.tobytes()
    assert list(together.results) == list(alone.results)
    assert repr(list(together.outcomes.values())) == repr(list(alone.outcomes.values()))
    for label, history in alone.history.items():
        assert [dataclasses.replace(r, seconds=0.0) for r in together.history[label]] == [
            dataclasses.replace(r, seconds=0.0) for r in history
        ]
        assert seen.get(label, []) == [r.i for r in history]


def test_results_do_not_depend_on_the_number_of_threads_of_blas(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2" if os.environ["OPENBLAS_NUM_THREADS"] == "1" else "1")
    child = [sys.executable, "-m", "tests.ilf.completion.blas_bits"]
    assert subprocess.run(child, stdout=subprocess.PIPE, text=True, check=True).stdout.split() == bits()


def test_one_thread_steps_through_the_blocks_in_order_and_no_faster_than_asked(small_frame, small_labels):
    parameters = ilf.preset(max_iterations=2, correction=False)
    with ilf.Run(small_frame, small_labels, parameters).steps(1) as run:
        before = set(threading.enumerate())
        steps = [(p.label, p.record and p.record.i) for p in run]
        # not counting the timer of a network, which ends a moment after it is cancelled
        assert not [one for one in set(threading.enumerate()) - before if one.name.startswith("ilf")]
    assert steps == [(1, 1), (1, 2), (1, None), (2, 1), (2, 2), (2, None)]


def test_a_run_that_is_closed_or_left_has_no_threads(small_frame, small_labels):
    def own():
        return [thread.name for thread in threading.enumerate() if thread.name.startswith("ilf")]

    endless = ilf.preset("released-code", max_iterations=100_000)
    usual = sys.getswitchinterval()
    run, other = (ilf.Run(small_frame, small_labels, endless).steps(2) for _ in range(2))
    assert not own(), "nothing begins before the first next()"
    next(run)
    next(other)
    assert own()
    run.close()
    assert own()
    assert sys.getswitchinterval() < usual
    other.close()
    assert not own()
    assert sys.getswitchinterval() == usual
    with pytest.raises(StopIteration):
        next(run)
    run = ilf.Run(small_frame, small_labels, endless).steps(2)
    next(run)
    del run
    assert not own()


def test_an_error_in_a_thread_comes_out_at_next(small_frame, small_labels, monkeypatch):
    def broken(task, *_):
        if task.block.label == 2:
            raise MemoryError("no room for block 2")
        return PassBandIteration(task.frame, task.block, task.parameters)

    monkeypatch.setattr(BlockTask, "stepper", broken)
    with pytest.raises(MemoryError, match="block 2"):
        ilf.complete(small_frame, small_labels, ilf.preset("released-code", max_iterations=100_000), threads=2)


def test_a_constant_in_the_place_of_missing_depth_is_doubted_in_arrays_as_in_files(small_frame, small_labels):
    marked = small_frame.changed(depth=np.where(small_frame.known, small_frame.depth, 65.535))
    with pytest.warns(ilf.DepthWarning, match=r"65\.535 m most likely marks missing depth"):
        ilf.complete(marked, small_labels, "paper", max_iterations=1)


def test_depth_that_is_not_positive_is_no_depth():
    """Beside a step the filter swings below 0: there the pixel stays missing, and is counted."""
    depth = np.linspace(8.9, 9.0, 900).reshape(30, 30)
    depth[:, :15] /= 60
    depth[5:25, 10:15] = np.nan
    frame = ilf.RGBDFrame(np.zeros((30, 30, 3), np.uint8), depth)
    parameters = ilf.preset("paper", shortest_wavelength=6.0, rgb_iterations=0)
    result = ilf.complete(frame, np.ones((30, 30), np.int32), parameters)
    outcome = result.outcomes[1]
    left = int(np.isnan(result.depth).sum())
    assert left > 0
    assert not (result.depth <= 0).any()
    assert outcome.recovered + left == 20 * 5
    assert f"{counted(left, 'pixel')} left missing" in outcome.message


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (np.ones((3, 3), np.int32), "but the frame is"),
        (np.ones((48, 64)), "integers"),
        (np.full((48, 64), -1, np.int32), "integers"),
    ],
)
def test_label_maps_that_do_not_fit_are_refused(small_frame, labels, message):
    with pytest.raises(InputError, match=message):
        ilf.complete(small_frame, labels)


def test_unknown_block_is_refused(small_frame, small_labels):
    with pytest.raises(InputError) as refused:
        ilf.iterate(small_frame, small_labels, 9)
    assert str(refused.value) == "There is no block 9. Blocks: 1, 2."
    with pytest.raises(InputError, match=r"There is no block 9\. Blocks: none\."):
        ilf.iterate(small_frame, np.zeros_like(small_labels), 9)


def test_a_block_without_depth_cannot_be_iterated_on(small_frame):
    labels = np.zeros(small_frame.shape, np.int32)
    labels[12:20, 10:18] = 4
    with pytest.raises(InputError, match="Block 4 has no known depth"):
        ilf.iterate(small_frame, labels, 4)


@pytest.mark.parametrize(
    "parameters",
    [ilf.preset("best", correction=False), ilf.preset("released-code"), ilf.preset("paper", precision="float32")],
)
def test_a_truth_gives_every_record_its_error_and_changes_nothing_else(small_frame, small_labels, parameters):
    ground_truth = np.where(small_frame.known, small_frame.depth + 9, 2.5)
    evaluated = small_frame.with_ground_truth(ground_truth)
    without, completion = (ilf.complete(frame, small_labels, parameters) for frame in (small_frame, evaluated))
    np.testing.assert_array_equal(completion.depth, without.depth)
    for label, history in completion.history.items():
        block = completion.results[label].block
        missing = np.isnan(small_frame.depth[block.box][block.mask])
        error = completion.results[label].depth[missing] - 2.5
        assert history[-1].error == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-5)
        assert [dataclasses.replace(record, error=np.nan, seconds=0) for record in history] == [
            dataclasses.replace(record, seconds=0) for record in without.history[label]
        ]


def test_tasks_are_begun_as_long_as_there_is_room_for_them():
    sizes, pending_work, loads = [12, 8, 4, 2, 1], [], []
    lock = threading.Lock()

    def task(size):
        with lock:
            pending_work.append(size)
            loads.append(sum(pending_work))
        time.sleep(0.01)
        yield size
        with lock:
            pending_work.remove(size)

    assert sorted(run_in_parallel([task(size) for size in sizes], 3, sizes, room=10)) == sorted(sizes)
    assert loads[0] == 12, "what there is never room for is begun alone"
    assert max(loads[1:]) <= 10


def test_a_thread_that_waits_for_room_ends_when_nobody_wants_more():
    steps = run_in_parallel([iter(range(1000)), iter(range(1000))], 2, [1, 1], room=1)
    next(steps)
    steps.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("ilf-block")]

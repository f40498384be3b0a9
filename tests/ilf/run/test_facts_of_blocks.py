"""A new fact about blocks is a field of `Blocks`: a run, all that is made of it, and a frame's state carry it."""

from dataclasses import dataclass, replace

import numpy as np

import ilf
from ilf.evaluation.sweep import Sweep, run_sweep
from ilf.project.exporting import run_and_completion
from ilf.project.frame_state import FrameState

from ..small_frames import QUICK
from ..small_runs import small_run


@dataclass(frozen=True, eq=False)
class BlocksWithGlass(ilf.Blocks):
    """Blocks, of which some are said to be of glass."""

    glass: frozenset[int] = frozenset()


def test_what_is_said_about_blocks_goes_wherever_they_go(tmp_path):
    frame = small_run(tmp_path).frame
    labels = np.where(np.arange(80) < 40, 1, 2) + np.zeros(frame.shape, int)
    blocks = BlocksWithGlass(labels, own={2: {"smoothness": 2.0}}, glass=frozenset({2}))
    run = ilf.Run(frame, blocks, ilf.preset(**QUICK))
    completion, test = run.complete(), ilf.HoldOutTest("random", (0,))
    state = FrameState("a1", frame, blocks, run.parameters, completion.results)
    sweep = run_sweep(Sweep(run, {"smoothness": [1.0, 3.0]}, test, only=[2]))
    runs = {
        "all arguments": ilf.Run.of(frame, blocks, drawn=labels == 1, own={1: "paper"}),
        "other inputs": replace(run, only=[1]).with_parameters(ilf.preset("paper")),
        "completion": completion.run,
        "extrapolation": ilf.extrapolate(completion).run,
        "hold-out": ilf.evaluate_hold_out(completion, test).run,
        "sweep": sweep.best.run,
        "frame": state.run(),
        "present results": state.present_run(),
        "export": run_and_completion(state)[0],
    }
    said = {name: getattr(one.blocks, "glass", None) for name, one in runs.items()}
    assert said == dict.fromkeys(runs, frozenset({2}))


def test_blocks_stand_where_a_label_map_does(tmp_path):
    run = small_run(tmp_path)
    wanted = run.complete().depth
    assert np.array_equal(ilf.complete(run.frame, run.blocks, run.parameters).depth, wanted)
    assert np.array_equal(np.asarray(run.blocks), run.blocks.labels)
    assert not ilf.Run.of(run.frame, run.blocks).blocks.edited, "they are as they were extracted"
    assert ilf.Run.of(run.frame, np.asarray(run.blocks)).blocks.edited, "nobody knows what they come from"
    both = [[*ilf.iterate(run.frame, blocks, 1, "paper")] for blocks in (run.blocks, run.blocks.labels)]
    assert len(both[0]) == len(both[1])

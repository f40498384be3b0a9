"""A frame's state with something in every place of it, and how two states are told apart."""

import dataclasses
import datetime
import math
from pathlib import Path

import numpy as np

import ilf
from ilf.data.blocks import BlockInfo
from ilf.data.by_hand import DepthByHand
from ilf.data.guide import Guide, GuideCard
from ilf.evaluation.quality.places import IgnoredPlace
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState, InspectionState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.run_history import Extrapolation, StoredRun
from ilf.sources.frame_ref import FrameRef

from .small_frames import CAMERA, QUICK, write_small_frame


def small_frame(folder: Path) -> ilf.RGBDFrame:
    """The small frame from files in a folder, with the truth of a file."""
    rgb, depth = write_small_frame(folder)
    ground_truth = folder / "truth.npy"
    np.save(ground_truth, np.full((60, 80), 2.0, np.float32))
    return ilf.load_frame(rgb, depth, intrinsics=CAMERA, ground_truth=ground_truth)


def made_frame() -> ilf.RGBDFrame:
    """A frame that a program has made, with a truth."""
    rng = np.random.default_rng(0)
    depth = rng.uniform(1, 3, (60, 80)).astype(np.float32)
    depth[20:30, 30:50] = np.nan
    colour = rng.integers(0, 255, (60, 80, 3), dtype=np.uint8)
    return ilf.RGBDFrame(colour, depth, name="made", ground_truth=np.full((60, 80), 2.5))


def rich_state(frame: ilf.RGBDFrame, frame_id: str = "ab12") -> FrameState:
    """A state of a 80 x 60 frame with results, two kept runs, a guess, notes and all else that there is."""
    mask = np.zeros(frame.shape, bool)
    mask[44:50, 4:10] = True
    drawn = np.zeros(frame.shape, bool)
    drawn[10:20, 39] = True
    labels = np.zeros(frame.shape, np.int32)
    labels[:, :40], labels[:30, 40:], labels[50:, 50:] = 1, 2, 70_000
    former = np.where(labels > 1, 1, labels).astype(np.int32)
    stated = np.full(frame.shape, np.nan, np.float32)
    stated[22:26, 12:60] = 1.75
    by_hand = DepthByHand(stated, 0.6)
    guide = Guide(np.linspace(0.5, 4, 4800).reshape(60, 80), np.full((60, 80), 0.5), "elsewhere.npy")
    guide = dataclasses.replace(
        guide, network=GuideCard("depth", "Somebody", "MIT", "metric", 12, sha256="0" * 64, size=518)
    )
    quick = ilf.preset(**QUICK)
    paper = ilf.preset("paper", **QUICK)
    early = ilf.Run(frame, ilf.Blocks(former, own={1: {"stage_step": 1.0}}, notes=("First of all.",)), paper, only=(1,))
    blocks = ilf.Blocks(
        labels, own={2: {"smoothness": 2.0}}, drawn=drawn, by_hand=by_hand, extracted=labels,
        extraction=ilf.BlockParameters(granularity=0.4), network="0" * 64,
    )  # fmt: skip
    late = ilf.Run(frame.with_invalid_mask(mask).with_guide(guide), blocks, quick, extrapolate=True)
    early_result, late_result = early.complete(), late.complete()
    told = dataclasses.replace(late_result.results[1], notes=("Canny stood in.",), network="a" * 64)
    late_result = dataclasses.replace(late_result, results=late_result.results | {1: told})
    results = {label: late_result.results[label] for label in (2, 1)}
    runs = (
        StoredRun(
            1, "first", early, early_result.results, 1.25, (1, 2, 3), "as the paper",
            done=frozenset({1}), expected_error=0.5,
        ),
        StoredRun(
            4, "é / \n", late, late_result.results, 0.1, (250, 0, 9), "",
            datetime.datetime(2024, 2, 29, 12, 0, 1, 5), frozenset({1, 2, 70_000}), "cancelled",
            Extrapolation.of(late_result), 0.1 + 0.2, math.nan, None, ilf.HoldOutTest("random", (3, 1)),
        ),
    )  # fmt: skip
    return FrameState(
        id=frame_id,
        frame=frame.with_invalid_mask(mask).with_guide(guide),
        blocks=ilf.Blocks(
            labels,
            {1: BlockInfo("wall", (9, 8, 7), False, True), 99: BlockInfo("gone", (0, 0, 255))},
            {2: {"smoothness": 2.0}},
            drawn,
            by_hand,
            ilf.BlockParameters(granularity=0.4),
            "f" * 64,
            former,
            frozenset({1}),
            frozenset({1, 99}),
            "the frame before",
            {2: "It was not in the picture before."},
            ("An edge network was missing.",),
        ),
        common=quick,
        results=results,
        extrapolation=Extrapolation.of(late_result),
        runs=runs,
        compared=(4, 1),
        next_number=6,
        extrapolate=True,
        own_parameters=True,
        note="Look again.",
        done=True,
        to_check=frozenset({2}),
        ignored=(IgnoredPlace("border", (2, 1), (40.5, 12.25), 2**32 - 1),),
        selected=(2, 1),
        looked=InspectionState(((0.5, 1.25), (70.0, 3.0)), (slice(3, 9), slice(2, 80)), (((1.0, 2.0), (3.0, 4.5)),)),
        view={"zoom": 1.5, "layout": ["a", None, True]},
    )


def through_project(frame: ilf.RGBDFrame, path: Path) -> ilf.RGBDFrame:
    """The frame as it comes back from a project file."""
    listed = ProjectFrame("a1", "one", FrameRef.of(frame.inputs), FrameSummary(Stage.UNTOUCHED), True)
    save_project(path, Project((listed,)), [FrameState("a1", frame, ilf.Blocks(np.ones(frame.shape, np.int32)))])
    with ilf.open_project(path) as opened:
        return opened.state("a1").state.frame


def assert_same(one: object, other: object, what: str = "state") -> None:
    """Everything in two states is the same, down to the bits of arrays."""
    if isinstance(one, ilf.RGBDFrame):
        assert isinstance(other, ilf.RGBDFrame)
        for name in (
            "rgb",
            "measured",
            "depth",
            "invalid_mask",
            "ground_truth",
            "guide",
            "intrinsics",
            "name",
            "inputs",
        ):
            assert_same(getattr(one, name), getattr(other, name), f"{what}.{name}")
    elif isinstance(one, np.ndarray):
        assert isinstance(other, np.ndarray), what
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes()), what
    elif dataclasses.is_dataclass(one):
        assert type(one) is type(other), what
        for field in dataclasses.fields(one):
            if not field.name.startswith("_"):
                assert_same(getattr(one, field.name), getattr(other, field.name), f"{what}.{field.name}")
    elif isinstance(one, dict) or hasattr(one, "items"):
        assert list(one) == list(other), what
        for key in one:
            assert_same(one[key], other[key], f"{what}[{key!r}]")
    elif isinstance(one, tuple):
        assert len(one) == len(other), what
        for place, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{what}[{place}]")
    else:
        assert type(one) is type(other), what
        assert one == other or (one != one and other != other), (what, one, other)

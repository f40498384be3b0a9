"""Commands in any order, on frames of two sizes: nothing breaks while things are under way, and what is closed goes."""

import gc
import random
import weakref
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent

from gui.features.curves import CurvesFeature
from gui.features.filter import FilterPanel
from gui.state.parts import Part
from gui.views.layers import CONTENTS
from gui.views.layouts import LAYOUTS
from gui.views.view_data import COMPARABLE, SIDES
from ilf.data.frame import RGBDFrame

from ..gui.states import edit
from .conftest import open_frame, write_frame

STEPS = 100
GIVEN = (
    *("run", "run_all", "cancel", "pause", "step", "extrapolate", "clear_results", "undo", "undo", "redo", "extract"),
    *("next_frame", "next_frame", "merge_blocks", "compare_runs", "accept_run", "restore_run", "delete_runs"),
    *("swipe", "blink", "show_before_edit", "swap_sides", "compare_two", "live", "layout_inspect", "layout_tune"),
    *("propagate_next", "propagate_next", "propagate_previous", "propagate_copied", "propagate_auto"),
    *("mark_checked", "share_parameters", "keep_own_parameters", "reset_to_shared"),
    *("separate_parameters", "next_check", "apply_remedy", "ignore_check"),
)


def test_commands_in_any_order(window, qtbot, small_frame, tmp_path):
    part = np.s_[:36, :50]
    smaller = RGBDFrame(small_frame.rgb[part], small_frame.depth[part], (60.0, 60.0, 24.5, 17.5))
    for number, frame in enumerate((replace(small_frame), smaller)):
        open_frame(window, qtbot, write_frame(tmp_path / f"frame-{number}", frame))
    for title in ("Runs", "Accuracy", "Inspect", "Range", "Convergence"):
        window.panels.reveal(title)
    chance, workspace, views = random.Random(1), window.workspace, window.views

    def edit_box():
        row, column = chance.randrange(30), chance.randrange(40)
        label = chance.choice([0, *workspace.current.counts()])
        edit(workspace, label, rows=np.s_[row : row + 8], columns=np.s_[column : column + 9])

    def mark_invalid():
        mask = np.zeros(workspace.current.frame.shape, bool)
        mask[: chance.randrange(9), :9] = True
        workspace.current.set_invalid_mask(mask, "MarkInvalid")

    def state_depth():
        shape = workspace.current.frame.shape
        depth = np.full(shape, chance.choice([np.nan, 1.5, 2.0]), np.float32)
        where = np.zeros(shape, bool)
        where[chance.randrange(20) :, chance.randrange(20) :] = True
        workspace.current.set_by_hand(depth, where, "Paint depth")

    def evaluate():
        frame = workspace.current.frame
        workspace.current.set_ground_truth(chance.choice([None, np.where(frame.known, frame.depth, np.float32(2))]))

    def inspect():
        document, (height, width) = workspace.current, workspace.current.frame.shape
        ends = [(chance.random() * width, chance.random() * height) for _ in range(2)]
        document.look(Part.MARKS, line=chance.choice([None, (ends[0], ends[1])]))
        document.look(Part.REGION, region=chance.choice([None, (slice(3, 30), slice(5, 40))]))
        document.set_measurements([*document.state.looked.measurements[-2:], (ends[0], ends[1])])

    others: list[Callable[[], object]] = [
        lambda: workspace.select(list(workspace.current.counts())[chance.randrange(3) :][:1]),
        lambda: window.feature(FilterPanel).set_values({"smoothness": chance.choice([0.5, 1.0, 3.0])}),
        lambda: workspace.current.compare_runs(workspace.current.state.runs[-chance.randrange(1, 4) :]),
        lambda: views.sheet.set_layout(chance.choice(list(LAYOUTS))),
        lambda: views.set_content(chance.choice(list(views.cells)), chance.choice([*CONTENTS, *SIDES])),
        lambda: views.sides.choose(chance.choice(["", *COMPARABLE]), chance.choice(["", *COMPARABLE])),
        lambda: window.feature(CurvesFeature).widget.scrub_bar._slider.setValue(chance.randrange(1, 9)),
        *(edit_box, edit_box, mark_invalid, state_depth, evaluate, inspect),
    ]
    for _ in range(STEPS):
        if chance.random() < 0.5:
            window.actions_[chance.choice(GIVEN)].trigger()  # what cannot be given now does nothing
        else:
            chance.choice(others)()
        qtbot.wait(chance.choice([0, 0, 1, 20]))

    open_ones = [weakref.ref(document) for document in workspace.open]
    while workspace.shown is not None:
        workspace.remove_entries([workspace.current_entry])
    window.refresh.now()

    def all_gone() -> bool:
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        gc.collect()
        return not any(document() for document in open_ones)

    qtbot.waitUntil(all_gone)

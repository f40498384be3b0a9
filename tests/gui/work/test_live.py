"""Depth that follows edits, and the line that says what they did, without a window."""

import math

import numpy as np
import pytest
from PySide6.QtGui import QPalette

import ilf
from gui.base.theme import colours
from gui.features.edit_summary import summary_html
from gui.work.frame_runs import LiveSolver, RunState
from ilf.data.guide import Guide
from ilf.evaluation.edit_summary import EditSummary
from ilf.segmentation.editing.patches import LabelPatch

from ..states import QUICK

Completed = tuple[ilf.Completion | None, ilf.Completion | None]


@pytest.fixture
def solver(bench, live):
    return LiveSolver(bench.workspace, bench.runs, live)


@pytest.fixture
def line(summary):
    return summary.line


def _patch(bench, label: int, column: int = 26) -> LabelPatch:
    return bench.patch(label, np.s_[5:20], np.s_[column:34])


def _asked(bench) -> list[list[int]]:
    """Blocks of every run, in the order that was asked for."""
    return [list(steps.run.only or steps.blocks) for steps in bench.script.runs]


def test_an_edit_that_was_undone_has_nothing_solved_for_values_that_are_set_later(bench, solver, until):
    bench.run_all()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    until(lambda: bench.document.changed_blocks() == [] and bench.runs.state is RunState.IDLE)
    bench.document.undo_stack.undo()
    bench.workspace.parameters.set(QUICK)
    asked = _asked(bench)
    bench.runs.state_changed.emit()
    assert (_asked(bench), bench.runs.state) == (asked, RunState.IDLE)


def test_touched_blocks_are_solved_again_the_chosen_one_first(bench, solver, until):
    bench.run_all()
    bench.workspace.select([2])
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    until(lambda: bench.document.changed_blocks() == [])
    assert _asked(bench) == [[1, 2], [2, 1]]
    bench.document.undo_stack.undo()
    assert bench.runs.state is RunState.IDLE, "what undo brings back needs no solving"
    assert bench.document.changed_blocks() == []


def test_nothing_is_solved_before_a_first_run_or_where_it_is_not_wanted(bench, solver, live):
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    assert bench.runs.state is RunState.IDLE
    bench.run_all()
    live.setChecked(False)
    bench.document.undo_stack.undo()
    assert bench.runs.state is RunState.IDLE
    assert bench.document.changed_blocks() == [1, 2]


@pytest.mark.parametrize("first", [True, False])
def test_what_is_touched_during_a_run_is_solved_after_it(bench, solver, until, first):
    if not first:
        bench.run_all()
    bench.runs.of(bench.document).toggle_pause()
    bench.runs.current.start()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    bench.script.allow()
    until(lambda: len(bench.script.runs) == 3 - first)
    until(lambda: bench.document.changed_blocks() == [])
    assert bench.said[-1].endswith("2 blocks edited meanwhile.")


def test_what_a_turn_to_another_frame_drops_is_solved_when_the_first_is_shown_again(bench, solver, until):
    bench.run_all()
    first = bench.document
    other = bench.open("second")
    bench.workspace.show(first)
    bench.script.__init__()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    bench.workspace.current.edit(_patch(bench, 2, 24), "Paint")
    bench.workspace.show(other)
    bench.rest()
    assert first.changed_blocks() != []
    bench.workspace.show(first)
    until(lambda: first.changed_blocks() == [])


def test_what_is_cancelled_is_not_asked_for_again(bench, solver, until):
    bench.run_all()
    bench.script.__init__()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    bench.runs.current.cancel()
    bench.rest(1)
    assert bench.document.changed_blocks() == [1, 2]
    bench.script.allow()
    bench.workspace.current.edit(_patch(bench, 2, 24), "Paint")
    until(lambda: bench.document.changed_blocks() == [])


@pytest.mark.parametrize(
    "change",
    [
        lambda document: document.set_invalid_mask(np.indices(document.frame.shape)[0] < 4, "Distrust depth"),
        lambda document: document.set_guide(Guide(1 + np.indices(document.frame.shape)[0]), "Load guide"),
    ],
    ids=["invalid depth", "guide"],
)
def test_another_layer_of_the_frame_may_have_a_part_in_all_blocks(bench, solver, until, change):
    bench.run_all()
    assert change(bench.workspace.current)
    until(lambda: bench.document.changed_blocks() == [])
    assert _asked(bench)[1:] == [[1, 2]]


def test_an_edit_is_said_at_once_and_what_it_did_when_it_is_known(bench, solver, line, until, monkeypatch):
    asked: list[tuple[ilf.Run, ilf.Run, Completed]] = []

    def find(before: ilf.Run, after: ilf.Run, patch: LabelPatch, completed: Completed) -> EditSummary:
        asked.append((before, after, completed))
        return EditSummary(60, None, (0.02, 0.01), (0.04, 0.03), 99)

    monkeypatch.setattr("gui.features.edit_summary.summarise_edit", find)
    assert "appears here" in line.label.text()
    former = bench.document.labels.copy()
    bench.run_all()
    bench.workspace.current.edit(_patch(bench, 2), "Paint <Block> 2")
    assert "<b>Paint &lt;Block&gt; 2</b>" in line.label.text()
    assert "60 px moved" in line.label.text()
    until(lambda: "hold-out 40.0\u00a0→\u00a0" in line.label.text())
    assert "expected RMS 20.0\u00a0→\u00a0" in line.label.text()
    before, after, (earlier, later) = asked[0]
    np.testing.assert_array_equal(before.blocks, former)
    np.testing.assert_array_equal(after.blocks, bench.document.labels)
    assert later is bench.document.completion()
    assert earlier.results[1].depth.size == (former == 1).sum()
    bench.document.undo_stack.undo()
    assert "Undone: Paint" in line.label.text()
    bench.open("second")
    bench.workspace.tell()
    assert "appears here" in line.label.text()


def test_other_blocks_and_other_depth_leave_no_word_of_the_last_edit(bench, solver, line, summary, until):
    bench.run_all()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    assert "Paint" in line.label.text()
    bench.workspace.current.replace_blocks(np.ones_like(bench.document.labels), "Load blocks")
    bench.workspace.tell()
    assert "Paint" not in line.label.text()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    wrong = np.zeros(bench.document.labels.shape, bool)
    wrong[8:12, 3:8] = bench.document.frame.known[8:12, 3:8]
    assert bench.workspace.current.set_invalid_mask(wrong, "Distrust depth")
    assert "Paint" not in line.label.text()
    assert "Distrust depth" in line.label.text()
    until(lambda: not summary.busy and bench.runs.state is RunState.IDLE)


def _text(*effect: object, margin: float = math.inf) -> tuple[str, list[str]]:
    """What is said of an effect, and its tones."""
    text = summary_html("Edit", EditSummary(3, *effect, margin=margin), "", colours(QPalette()))
    return text, [part[:7] for part in text.split("color:")[1:]]


def test_better_is_green_and_worse_is_red(qapp):
    text, (better, worse) = _text(None, None, (0.2, 0.3), 50, (0.05, 0.04), margin=0.05)
    assert better != worse
    assert "±" not in text
    # neither within the margin, nor by the expected error, nor by pixels that are filled
    text, tones = _text((500, 900), (0.05, 0.01), (0.2, 0.1), 50, (0.05, 0.0501), margin=0.15)
    assert not {better, worse} & set(tones)
    assert "200\u00a0→\u00a0" in text
    assert "(±150 mm)" in text
    text, tones = _text(None, None, (0.2, 0.1), 50)
    assert not {better, worse} & set(tones), "of an unknown margin"
    assert "±" not in text


def test_an_edit_is_judged_by_the_truth_first_also_by_one_that_is_loaded_later(bench, solver, line, until, monkeypatch):
    def find(before: ilf.Run, after: ilf.Run, *_: object) -> EditSummary:
        return EditSummary(60, by_ground_truth=None if after.frame.ground_truth is None else (0.1, 0.06))

    monkeypatch.setattr("gui.features.edit_summary.summarise_edit", find)
    bench.run_all()
    bench.workspace.current.edit(_patch(bench, 2), "Paint")
    until(lambda: "too little known depth nearby" in line.label.text())
    bench.workspace.current.set_ground_truth(np.full(bench.document.frame.shape, 2.0, np.float32))
    until(lambda: "ground truth 100\u00a0→\u00a0" in line.label.text())
    assert "too little known depth" not in line.label.text()
    words, _ = _text(None, (0.05, 0.04), (0.2, 0.3), 50, (0.1, 0.06))
    assert "ground truth 100\u00a0→\u00a0" in words
    assert words.index("ground truth") < words.index("hold-out") < words.index("expected RMS")

"""What is known of one state of a frame is never taken for another's: results, edits, values, what is to be solved."""

from threading import Event

import numpy as np
import pytest

import ilf
from gui.features.derived import DerivedFeature
from gui.features.export.feature import behind
from gui.state.document import Document
from gui.state.parts import Part
from gui.work.frame_runs import LiveSolver, RunState
from ilf.evaluation.edit_summary import EditSummary
from ilf.segmentation.edges.frame_edges import FrameEdges


@pytest.fixture
def look(bench, context, summary, live):
    """Show the state before the last edit, or go back; blocks are solved after edits."""
    summary.solver = LiveSolver(bench.workspace, bench.runs, live)
    return context.actions["show_before_edit"].setChecked


def test_results_of_a_run_are_of_the_depth_that_it_was_begun_with(bench):
    bench.runs.current.start()
    mask = np.zeros(bench.frame.shape, bool)
    mask[:4, :4] = True
    bench.workspace.current.set_invalid_mask(mask, "Distrust depth")
    bench.finish()
    assert bench.document.valid_results() == {}
    bench.document.undo_stack.undo()
    assert set(bench.document.valid_results()) == {1, 2}


def test_a_stroke_does_not_bring_back_the_result_of_other_drawn_borders(bench):
    bench.run_all()
    block = bench.document.labels == 2
    bench.workspace.current.edit(bench.patch(1, np.s_[:], np.s_[30:]), "Give")
    bench.workspace.current.stroke(bench.patch(2, np.s_[:], np.s_[30:]))
    bench.document.valid_results()  # as the views ask for them during a stroke
    bench.workspace.current.edit(bench.workspace.current.drop_stroke(), "Paint")
    assert bench.document.blocks.drawn[block].any()
    assert 2 not in bench.document.valid_results()


def test_an_edit_is_judged_against_the_drawn_borders_that_there_were(bench, look, until, monkeypatch):
    asked = []

    def find(before, after, patch, completed):
        asked.append((before, after))
        return EditSummary(1)

    monkeypatch.setattr("gui.features.edit_summary.summarise_edit", find)
    bench.run_all()
    for count, column in enumerate((26, 22), 1):
        drawn = bench.document.blocks.drawn
        former = None if drawn is None else drawn.copy()
        bench.workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[column:30]), "Paint")
        until(lambda count=count: len(asked) == count)
        before, after = asked[-1]
        np.testing.assert_array_equal(after.blocks.drawn, bench.document.blocks.drawn)
        if former is None:
            assert before.blocks.drawn is None
        else:
            np.testing.assert_array_equal(before.blocks.drawn, former)
    bench.document.undo_stack.undo()
    until(lambda: len(asked) == 3)
    np.testing.assert_array_equal(asked[2][0].blocks.drawn, asked[1][1].blocks.drawn)
    np.testing.assert_array_equal(asked[2][1].blocks.drawn, asked[1][0].blocks.drawn)


def test_what_is_shown_while_one_looks_back_stays(bench, look, views):
    bench.run_all()
    completion, former = bench.document.completion(), bench.document.labels.copy()
    bench.workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[26:30]), "Paint")
    look(True)
    views.refresh(Part.RESULTS)  # as when a block has been solved meanwhile
    views.blocks.draw(Part.LABELS)
    assert views.data.result.depth is completion.depth
    np.testing.assert_array_equal(views.blocks.labels, former)
    look(False)
    assert views.data.result.depth is not completion.depth
    np.testing.assert_array_equal(views.blocks.labels, bench.document.labels)


def test_who_looks_back_while_a_frame_of_another_size_comes_sees_that(bench, look, views):
    bench.script.allow()
    bench.workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[26:30]), "Paint")
    look(True)
    small = np.s_[:20, :30]
    frame = ilf.RGBDFrame(bench.frame.rgb[small], bench.frame.depth[small])
    bench.workspace.open_document(Document.of(ilf.Run(frame, bench.labels[small]), None, "small"))
    look(False)  # as the window does when another frame is shown, before anything is drawn
    assert views.data.frame.rgb is frame.rgb
    np.testing.assert_array_equal(views.blocks.labels, bench.labels[small])


def test_edges_of_one_frame_do_not_come_to_the_next(bench, context, views, until, monkeypatch):
    found = Event()
    monkeypatch.setattr("gui.features.derived.find_edges", lambda *_: found.wait() and FrameEdges(*3 * [edges], None))
    monkeypatch.setattr(views, "shows", lambda part: part == "edges")
    edges = np.zeros(bench.frame.shape, np.float32)
    derived = DerivedFeature(context)
    derived.show("edges")
    small = np.s_[:20, :30]
    frame = ilf.RGBDFrame(bench.frame.rgb[small], bench.frame.depth[small])
    bench.workspace.open_document(Document.of(ilf.Run(frame, bench.labels[small]), None, "small"))
    views.look_back(None)  # as when the key that shows the state before an edit is released
    found.set()
    until(lambda: not derived.busy)
    assert views.data.edges is None


def test_blocks_of_one_frame_are_not_solved_in_another(bench, until):
    bench.script.records = 1000
    bench.runs.current.resolve([2, 1])
    bench.runs.current.resolve([2])
    bench.get_going(2)
    second = bench.open("second")
    bench.runs.current.resolve([1], edited=True)
    bench.script.records = 1
    bench.script.allow()
    until(lambda: set(second.valid_results()) == {1} and set(bench.document.valid_results()) == {1, 2})
    assert [list(steps.run.only) for steps in bench.script.runs if steps.run.frame is second.frame] == [[1]]


def test_an_edit_between_a_command_to_run_and_the_run_is_solved_after_it(bench, look, until):
    bench.run_all()
    bench.workspace.current.edit(bench.patch(3, np.s_[40:], np.s_[50:]), "Outline")
    bench.runs.current.start({3})
    bench.workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[26:30]), "Paint")
    until(lambda: bench.document.changed_blocks() == [])


def test_an_export_says_what_its_results_lack(bench):
    bench.run_all()
    assert behind(bench.document) == ""
    bench.workspace.current.edit(bench.patch(3, np.s_[40:], np.s_[50:]), "Outline")
    bench.workspace.parameters.set(bench.workspace.parameters.current.replace(max_iterations=7))
    assert behind(bench.document) == (
        "Not run in their current state, so that their missing depth stays missing: 2 of 3 blocks. "
        "Run with other parameters than the current ones: 1 of 3 blocks. Run them first (F5)."
    )


def test_of_a_drag_the_results_are_kept_that_undo_and_redo_lead_to(bench, until, monkeypatch):
    monkeypatch.setattr("gui.state.parameters.time.monotonic", lambda: 1.0)
    workspace, document = bench.workspace, bench.document

    def kept():
        return [one.result.parameters.max_iterations for one in document.results.kept[1]]

    def solve():
        bench.runs.current.resolve([1])
        until(lambda: bench.runs.state is RunState.IDLE)

    bench.run_all()
    first = workspace.parameters.current
    for limit in range(100, 110):
        workspace.parameters.set(first.replace(max_iterations=limit))
        solve()
    assert kept() == [first.max_iterations, 109]
    document.undo_stack.undo()
    assert document.is_up_to_date(1)
    solve()
    document.undo_stack.redo()
    assert document.is_up_to_date(1)
    workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[26:30]), "Paint")
    solve()
    assert sorted(kept()) == [109, 109, first.max_iterations], "undo may bring back the other state"


def test_a_preview_is_not_shown_where_its_block_is_no_more(bench):
    bench.run_all()
    block = bench.document.valid_results()[1].block
    bench.document.add_records(1, [])
    bench.document.add_previews([(block, np.full(block.mask.sum(), 9.0, np.float32))])
    bench.workspace.current.edit(bench.patch(2, np.s_[5:20], np.s_[26:30]), "Paint")
    depth = bench.document.current_depth()
    assert (depth[5:20, 26:30] != 9.0).all()
    assert (depth[:, :26] == 9.0).all()


def test_an_export_during_a_drag_has_not_saved_what_came_after(bench, monkeypatch):
    monkeypatch.setattr("gui.state.parameters.time.monotonic", lambda: 1.0)
    bench.workspace.parameters.set(bench.workspace.parameters.current.replace(max_iterations=7))
    state = bench.document.stamp
    bench.workspace.parameters.set(bench.workspace.parameters.current.replace(max_iterations=8))
    bench.document.note_saved(state)
    assert bench.document.unsaved

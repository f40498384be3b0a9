"""The window's state without widgets: documents, edits, and who is told of what."""

import numpy as np
import pytest

from gui.state.frame_data import LARGEST_LABEL
from gui.state.parts import NO_PART, Part
from gui.state.results import ErrorEstimate
from ilf.project.project import Stage

from ..states import edit

# sessions


def test_the_next_label_is_one_that_no_block_has_or_had(document):
    assert document.next_label() == 3
    document.info(7)
    assert document.next_label() == 8
    document.info(LARGEST_LABEL - 1)
    assert document.next_label() == LARGEST_LABEL
    document.info(LARGEST_LABEL)
    assert document.next_label() == 3, "the lowest that is free"
    free = LARGEST_LABEL - 1
    document.change_blocks(infos=dict.fromkeys(set(range(1, LARGEST_LABEL + 1)) - {free}, document.blocks.infos[free]))
    assert document.next_label() == LARGEST_LABEL - 1


# results while a run goes on


def test_an_expected_error_is_that_of_the_present_completion(workspace, document, results, told):
    doubt = ErrorEstimate(np.ones(document.frame.shape, np.float32), np.zeros(document.frame.shape, bool))
    document.add_results(results[:1])
    early = document.completion()
    document.add_results(results[1:])
    document.store_error_estimate(early, doubt)
    assert (document.expected_error(), document.unsupported(), told()) == (None, None, NO_PART)
    document.store_error_estimate(document.completion(), doubt)
    assert document.expected_error() is doubt.error
    assert document.unsupported() is doubt.unsupported
    assert told() == Part.EXPECTED_ERROR
    edit(workspace, 2)
    assert document.expected_error() is None
    told()
    workspace.current.clear_results()
    assert told() == Part.RESULTS


# frames


def test_opening_showing_and_closing_frames(workspace, document, other, told):
    assert workspace.current is document
    assert document is workspace.shown
    assert other is not workspace.shown
    workspace.show(document)
    assert told() == NO_PART
    workspace.show(other)
    assert told() == Part.FRAME
    assert workspace.undo_group.activeStack() is other.undo_stack
    workspace.remove_entries([workspace.entries.of(document.id)])
    assert workspace.current is other, "another than the present one was closed"
    workspace.remove_entries([workspace.entries.of(other.id)])
    assert workspace.shown is None
    assert workspace.chosen == 0
    assert workspace.undo_group.stacks() == [workspace.undo_group.activeStack()] or not workspace.undo_group.stacks()
    with pytest.raises(RuntimeError, match="no frame"):
        _ = workspace.current


def test_what_is_noted_on_a_frame_that_cannot_be_opened_hides_no_problem(workspace, document, other):
    workspace.unload(other)
    entry = workspace.entries.of(other.id)
    workspace.note_problem(entry, "files are missing")
    workspace.set_note(entry, "dark")
    workspace.set_done(entry, True)
    assert (entry.summary.stage, entry.summary.problem) == (Stage.FAILED, "files are missing")
    assert (entry.stored_summary.note, entry.stored_summary.problem) == ("dark", "")
    assert entry.stored_summary.stage is not Stage.FAILED


# edits


def test_a_chosen_block_that_is_gone_is_chosen_no_more(workspace, document):
    document.info(2)
    workspace.select([2, 1])
    edit(workspace, 1, rows=np.s_[:], columns=np.s_[:])
    assert document.selected == [1]
    new = workspace.current.start_block()
    assert (new, document.selected) == (3, [3])
    edit(workspace, 0)
    assert document.selected == [3], "it has never been there"


# extraction


def test_loaded_blocks_bring_their_names_also_where_locked_ones_have_their_numbers(workspace, document):
    document.change_info(2, name="Mine", locked=True)
    before = document.labels.copy()
    loaded = np.where(before == 2, 7, 2).astype(np.int32)
    loaded[:1][before[:1] != 2] = 1
    workspace.current.replace_blocks(loaded, "Load blocks", {1: "Wall", 2: "Floor", 7: "Under the locked one"})
    names = {label: document.info(label).name for label in document.counts()}
    assert names.pop(2) == "Mine"
    assert sorted(names.values()) == ["Floor", "Wall"]
    floor = next(label for label, name in names.items() if name == "Floor")
    np.testing.assert_array_equal(document.labels == floor, loaded == 2)
    workspace.undo_group.undo()
    assert document.info(1).name == "Block 1"

"""Everything that a project holds sets the mark of what is unsaved, and what is only looked at does not."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ilf
from gui.project.current_project import CurrentProject
from gui.state.document import Document
from gui.state.parts import Part
from gui.state.workspace import Entry, Workspace
from gui.work.run_recorder import first_run
from ilf.project.frame_state import FrameState
from ilf.project.run_history import StoredRun
from ilf.sources.frame_ref import FrameRef

from ..states import QUICK, QUICK_OWN, edit, extraction

Do = Callable[[Workspace, Document], object]


def _kept(document) -> StoredRun:
    return StoredRun(document.state.next_number, "Run", document.run(QUICK), {}, 0.1, (1, 2, 3))


def _mark_invalid(workspace, document):
    mask = np.zeros(document.labels.shape, bool)
    mask[:3, :3] = True
    workspace.current.set_invalid_mask(mask, "MarkInvalid")


def _extrapolation(workspace, document):
    base = document.completion()
    document.store_extrapolation(base, replace(base, extrapolated=base.filled))


WORK: dict[str, Do] = {
    "edit": lambda workspace, document: edit(workspace, 2),
    "name": lambda workspace, document: workspace.current.edit_info(1, "Rename", name="Wall"),
    "colour": lambda workspace, document: workspace.current.edit_info(1, "Recolour", colour=(1, 2, 3)),
    "lock": lambda workspace, document: workspace.current.set_lock(1, True),
    "visibility": lambda workspace, document: workspace.current.set_visible(1, False),
    "parameters": lambda workspace, document: workspace.parameters.set(QUICK),
    "own values": lambda workspace, document: workspace.parameters.set_own(QUICK_OWN, [1]),
    "distrusted depth": _mark_invalid,
    "depth by hand": lambda workspace, document: workspace.current.set_by_hand(
        np.full(document.labels.shape, 2.0, np.float32), document.frame.missing, "Paint depth"
    ),
    "ground_truth": lambda workspace, document: workspace.current.set_ground_truth(
        np.ones(document.labels.shape, np.float32)
    ),
    "other blocks": lambda workspace, document: workspace.current.replace_blocks(np.ones_like(document.labels), "Load"),
    "extraction": lambda workspace, document: document.set_extracted(
        extraction(document, np.ones_like(document.labels)), ilf.BlockParameters(), keep_handmade=True
    ),
    "results go": lambda workspace, document: workspace.current.clear_results(),
    "a guess": _extrapolation,
    "a run": lambda workspace, document: document.keep_run(_kept(document)),
    "a run's name": lambda workspace, document: document.change_run(document.state.runs[0], name="best"),
    "runs go": lambda workspace, document: document.delete_runs(document.state.runs[:1]),
    "a run goes": lambda workspace, document: document.drop_runs(document.state.runs[:1]),
    "note": lambda workspace, document: workspace.set_note(workspace.entries[1], "Look here."),
    "a block that is looked at": lambda workspace, document: workspace.current.mark_checked([1]),
    "a frame comes": lambda workspace, document: workspace.add_entries([Entry("new", "/a/b", "b", FrameRef("/a/b"))]),
    "a frame goes": lambda workspace, document: workspace.remove_entries([workspace.entries[0]]),
    "what blocks are extracted with": lambda workspace, document: workspace.parameters.set_extraction(
        ilf.BlockParameters(granularity=0.7)
    ),
    "whether blocks made by hand stay": lambda workspace, document: workspace.parameters.set_keeps_handmade(False),
    "parameters for all frames": lambda workspace, document: workspace.parameters.share(),
    "note on a frame that is not open": lambda workspace, document: _note_closed(workspace),
}

LOOKS: dict[str, Do] = {
    "selection": lambda workspace, document: workspace.select([2]),
    "another frame": lambda workspace, document: workspace.show(workspace.open[0]),
    "rectangle": lambda workspace, document: workspace.current.look(Part.REGION, region=(slice(1, 5), slice(2, 7))),
    "compared runs": lambda workspace, document: workspace.current.compare_runs(document.state.runs[:1]),
    "how good a run is": lambda workspace, document: document.touch(Part.HISTORY, viewing=True),
    "zoom": lambda workspace, document: document.change(view={"place": [1, 2, 3]}),
    "the first extraction": lambda workspace, document: _first_extraction(workspace, document),
}


def _note_closed(workspace):
    workspace.unload(workspace.open[0])
    workspace.set_note(workspace.entries[0], "Later.")


def _first_extraction(workspace, document):
    blocks = ilf.Blocks(np.zeros_like(document.labels))
    fresh = Document(FrameState("fresh", document.frame, blocks), "fresh", "fresh")
    workspace.open_document(fresh)
    fresh.set_first(extraction(document, document.labels), ilf.BlockParameters())
    assert not fresh.unsaved
    workspace.remove_entries([entry for entry in workspace.entries if entry.document is fresh])


@pytest.fixture
def saved(workspace, document, results):
    """A project with results and a kept run, of which the file holds all."""
    document.store_results(results)
    document.change(to_check=frozenset({1}))
    document.keep_run(_kept(document))
    present = CurrentProject(workspace)
    _save(present, workspace)
    return present


def _save(present: CurrentProject, workspace):
    for document in workspace.open:
        document.note_saved(document.stamp)
    for entry in workspace.entries:
        if entry.document is None:
            entry.set_unsaved(False)
    present.take(Path("room.ilf"))
    assert not present.unsaved


@pytest.mark.parametrize("do", WORK.values(), ids=WORK)
def test_work_is_unsaved_and_saved_work_is_not(saved, workspace, document, do):
    told: list[object] = []
    titled: list[None] = []
    workspace.touched.connect(told.append)
    workspace.project_touched.connect(lambda: told.append(None))
    workspace.on(Part.LIST | Part.CONTENT, lambda: titled.append(None))
    do(workspace, document)
    workspace.tell()
    assert saved.unsaved
    assert saved.words() or any(entry.unsaved_summary() for entry in workspace.entries)
    assert told, "who keeps the work has been told"
    assert titled or None in told, "and who shows that it is unsaved"
    _save(saved, workspace)


@pytest.mark.parametrize("do", LOOKS.values(), ids=LOOKS)
def test_what_is_only_looked_at_is_no_work(saved, workspace, document, do):
    do(workspace, document)
    assert not saved.unsaved


def test_the_work_is_told_in_words(saved, workspace, document):
    assert document.unsaved_summary() == ""
    workspace.current.set_lock(1, True)
    workspace.current.edit_info(1, "Rename", name="Wall")
    document.keep_run(_kept(document))
    assert document.unsaved_summary() == "2 edits, 1 run"
    workspace.unload(document)
    assert workspace.entries[1].unsaved_summary() == "2 edits, 1 run"
    workspace.current.set_visible(1, False)
    assert workspace.current.unsaved_summary() == "changes"
    again = Document.of_state(document.state, "/a", document.key)
    workspace.open_document(again, restored=True)
    again.keep_run(_kept(again))
    assert again.unsaved_summary() == "earlier changes, 1 run"
    again.note_saved(again.stamp)
    assert not again.unsaved


def test_the_run_of_an_opened_record_is_no_unsaved_work(workspace, document, results):
    document.store_results(results)
    recorded = Document.of(document.run(QUICK), "run.json", "run.json")
    workspace.open_document(recorded, recorded.run(QUICK), first=first_run(recorded, document.completion()))
    assert len(recorded.state.runs) == 1
    assert not recorded.unsaved
    recorded.edit_info(1, "Rename", name="Wall")
    assert recorded.unsaved_summary() == "1 edit"
    recorded.keep_run(_kept(recorded))
    assert recorded.unsaved_summary() == "1 edit, 1 run"


def test_without_a_file_a_list_of_frames_is_no_work(workspace, document, told):
    present = CurrentProject(workspace)
    workspace.add_entries([Entry("new", "/a/b", "b", FrameRef("/a/b"))])
    assert not present.unsaved
    told()
    workspace.parameters.set_keeps_handmade(False)
    assert told() == Part.EXTRACTION
    assert present.words() == "extraction parameters"
    workspace.parameters.set_keeps_handmade(True)
    assert not present.unsaved

"""Everything that a project holds sets the mark of what is unsaved, and what is only looked at does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gui.project.current_project import CurrentProject
from gui.state.entries import Entry
from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.data.blocks import Blocks
from ilf.data.parameters import BlockParameters
from ilf.data.results import BlockResult
from ilf.project.frame_state import FrameState
from ilf.project.run_history import StoredRun
from ilf.sources.frame_ref import FrameRef

from ..states import QUICK, QUICK_OWN, edit, extraction

Do = Callable[[Workspace, Session], object]


def _kept(session: Session) -> StoredRun:
    return StoredRun(session.state.next_number, "Run", session.run(QUICK), {}, 0.1, (1, 2, 3))


def _mark_invalid(workspace: Workspace, session: Session) -> None:
    mask = np.zeros(session.labels.shape, bool)
    mask[:3, :3] = True
    workspace.blocks.set_invalid_mask(mask, "MarkInvalid")


def _extrapolation(workspace: Workspace, session: Session) -> None:
    base = session.completion()
    assert base is not None
    workspace.runs.store_extrapolation(session, base, replace(base, extrapolated=base.filled))


WORK: dict[str, Do] = {
    "edit": lambda workspace, session: edit(workspace, 2),
    "name": lambda workspace, session: workspace.blocks.edit_info(1, "Rename", name="Wall"),
    "colour": lambda workspace, session: workspace.blocks.edit_info(1, "Recolour", colour=(1, 2, 3)),
    "lock": lambda workspace, session: workspace.blocks.set_lock(1, True),
    "visibility": lambda workspace, session: workspace.blocks.set_visible(1, False),
    "parameters": lambda workspace, session: workspace.parameters.set(QUICK),
    "own values": lambda workspace, session: workspace.parameters.set_own(QUICK_OWN, [1]),
    "distrusted depth": _mark_invalid,
    "depth by hand": lambda workspace, session: workspace.by_hand.set_depth(
        np.full(session.labels.shape, 2.0, np.float32), session.frame.missing, "Paint depth"
    ),
    "ground_truth": lambda workspace, session: workspace.blocks.set_ground_truth(
        np.ones(session.labels.shape, np.float32)
    ),
    "other blocks": lambda workspace, session: workspace.blocks.replace(np.ones_like(session.labels), "Load"),
    "extraction": lambda workspace, session: workspace.blocks.set_extracted(
        session, extraction(session, np.ones_like(session.labels)), BlockParameters()
    ),
    "results go": lambda workspace, session: workspace.runs.clear_results(),
    "a guess": _extrapolation,
    "a run": lambda workspace, session: workspace.runs.keep(session, _kept(session)),
    "a run's name": lambda workspace, session: workspace.runs.change(session, session.state.runs[0], name="best"),
    "runs go": lambda workspace, session: workspace.runs.delete(session, session.state.runs[:1]),
    "a run goes": lambda workspace, session: workspace.runs.drop(session, session.state.runs[0]),
    "note": lambda workspace, session: workspace.frames.set_note(workspace.frames.entries[1], "Look here."),
    "a block that is looked at": lambda workspace, session: workspace.blocks.mark_checked([1]),
    "a frame comes": lambda workspace, session: workspace.frames.add_entries(
        [Entry("new", "/a/b", "b", FrameRef("/a/b"))]
    ),
    "a frame goes": lambda workspace, session: workspace.frames.remove_entries([workspace.frames.entries[0]]),
    "what blocks are extracted with": lambda workspace, session: workspace.parameters.set_extraction(
        BlockParameters(granularity=0.7)
    ),
    "whether blocks made by hand stay": lambda workspace, session: workspace.parameters.set_keeps_handmade(False),
    "parameters for all frames": lambda workspace, session: workspace.parameters.share(),
    "note on a frame that is not open": lambda workspace, session: _note_closed(workspace),
}

LOOKS: dict[str, Do] = {
    "selection": lambda workspace, session: workspace.blocks.select([2]),
    "another frame": lambda workspace, session: workspace.frames.show(workspace.frames.sessions[0]),
    "rectangle": lambda workspace, session: workspace.blocks.set_region((slice(1, 5), slice(2, 7))),
    "compared runs": lambda workspace, session: workspace.runs.compare(session.state.runs[:1]),
    "how good a run is": lambda workspace, session: workspace.runs.note_measured(session),
    "zoom": lambda workspace, session: session.change(view={"place": [1, 2, 3]}),
    "the first extraction": lambda workspace, session: _first_extraction(workspace, session),
}


def _note_closed(workspace: Workspace) -> None:
    workspace.frames.unload(workspace.frames.sessions[0])
    workspace.frames.set_note(workspace.frames.entries[0], "Later.")


def _first_extraction(workspace: Workspace, session: Session) -> None:
    blocks = Blocks(np.zeros_like(session.labels))
    fresh = Session(FrameState("fresh", session.frame, blocks), "fresh", "fresh")
    workspace.add_session(fresh)
    workspace.blocks.set_first(fresh, extraction(session, session.labels), BlockParameters())
    assert not fresh.unsaved
    workspace.frames.remove_entries([entry for entry in workspace.frames.entries if entry.session is fresh])


@pytest.fixture
def saved(workspace: Workspace, session: Session, results: list[BlockResult]) -> CurrentProject:
    """A project with results and a kept run, of which the file holds all."""
    workspace.runs.store_results(session, results)
    session.change(to_check=frozenset({1}))
    workspace.runs.keep(session, _kept(session))
    present = CurrentProject(workspace, workspace)
    _save(present, workspace)
    return present


def _save(present: CurrentProject, workspace: Workspace) -> None:
    for session in workspace.frames.sessions:
        workspace.frames.note_saved(session, session.stamp)
    for entry in workspace.frames.entries:
        if entry.session is None:
            entry.set_unsaved(False)
    present.take(Path("room.ilf"))
    assert not present.unsaved


@pytest.mark.parametrize("do", WORK.values(), ids=WORK)
def test_work_is_unsaved_and_saved_work_is_not(
    saved: CurrentProject, workspace: Workspace, session: Session, do: Do
) -> None:
    told: list[object] = []
    workspace.frames.touched.connect(told.append)
    workspace.frames.project_touched.connect(lambda: told.append(None))
    do(workspace, session)
    assert saved.unsaved
    assert saved.words() or any(entry.unsaved_summary() for entry in workspace.frames.entries)
    assert told, "who keeps the work has been told"
    _save(saved, workspace)


@pytest.mark.parametrize("do", LOOKS.values(), ids=LOOKS)
def test_what_is_only_looked_at_is_no_work(
    saved: CurrentProject, workspace: Workspace, session: Session, do: Do
) -> None:
    do(workspace, session)
    assert not saved.unsaved


def test_the_work_is_told_in_words(saved: CurrentProject, workspace: Workspace, session: Session) -> None:
    assert session.unsaved_summary() == ""
    workspace.blocks.set_lock(1, True)
    workspace.blocks.edit_info(1, "Rename", name="Wall")
    workspace.runs.keep(session, _kept(session))
    assert session.unsaved_summary() == "2 edits, 1 run"
    workspace.frames.unload(session)
    assert workspace.frames.entries[1].unsaved_summary() == "2 edits, 1 run"
    workspace.blocks.set_visible(1, False)
    assert workspace.session.unsaved_summary() == "changes"


def test_without_a_file_a_list_of_frames_is_no_work(workspace: Workspace, session: Session) -> None:
    present = CurrentProject(workspace, workspace)
    workspace.frames.add_entries([Entry("new", "/a/b", "b", FrameRef("/a/b"))])
    assert not present.unsaved
    workspace.parameters.set_keeps_handmade(False)
    assert present.words() == "extraction parameters"
    workspace.parameters.set_keeps_handmade(True)
    assert not present.unsaved

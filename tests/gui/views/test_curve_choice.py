"""Which curves are shown, and that the line of the criterion says what the very block has."""

from __future__ import annotations

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

import ilf
from gui.features.curves import CurvesPresenter
from gui.features.filter.panel import FilterPanel
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.views.curves.panel import CurvesPanel
from ilf.data.results import BlockResult, IterationRecord
from ilf.project.run_history import StoredRun
from ilf.run.run import complete

QUICK = ilf.preset(max_iterations=5)


@pytest.fixture
def panel(qtbot: QtBot) -> CurvesPanel:
    panel = CurvesPanel()
    qtbot.addWidget(panel)
    panel.resize(700, 400)
    panel.show()
    return panel


@pytest.fixture
def presenter(workspace: Workspace, panel: CurvesPanel) -> CurvesPresenter:
    return CurvesPresenter(workspace, panel)


def test_the_chosen_blocks_are_shown_else_the_one_that_runs_else_the_longest(
    workspace: Workspace, panel: CurvesPanel, presenter: CurvesPresenter, results: list[BlockResult]
) -> None:
    presenter.show()
    assert panel.names == []
    workspace.runs.store_results(workspace.session, results)
    presenter.show()
    assert panel.names == ["Block 1"]
    workspace.runs.add_records(workspace.session, 2, [IterationRecord(1, 1, 0.1, 1.0, 0.0, np.nan, 0.0)])
    presenter.show()
    assert panel.names == ["Block 2"]
    assert len(panel.records) == 1
    workspace.blocks.select([2, 1])
    presenter.show()
    assert panel.names == ["Block 2", "Block 1"]
    workspace.blocks.select([1])
    presenter.show()
    assert panel.names == ["Block 1"]
    workspace.frames.show(None)
    presenter.show()
    assert panel.names == []


def test_compared_runs_are_shown_beside_the_present_result(
    workspace: Workspace, session: Session, panel: CurvesPanel, presenter: CurvesPresenter, results: list[BlockResult]
) -> None:
    workspace.runs.store_results(session, results)
    workspace.blocks.select([1])
    other = complete(session.frame, session.labels, ilf.preset("paper", max_iterations=12)).results
    kept = StoredRun(1, "Run 1", session.run(session.state.common), other, 1.0, (200, 0, 0))
    workspace.runs.keep(session, kept)
    workspace.runs.compare([kept])
    presenter.show()
    assert panel.names == ["Block 1", "Run 1"]
    assert [curve.dashed for curve in panel._curves] == [False, True]
    assert panel.sigma_plot.lines[1].getData()[0][-1] == len(other[1].history)
    workspace.blocks.select([1, 2])
    presenter.show()
    assert panel.names == ["Block 1", "Block 2", "Run 1: Block 1", "Run 1: Block 2"]


def test_the_criterion_is_that_of_the_filter_panel_for_the_block(
    qtbot: QtBot, workspace: Workspace, session: Session, panel: CurvesPanel, presenter: CurvesPresenter
) -> None:
    form = FilterPanel([], [])
    qtbot.addWidget(form)
    workspace.parameters.set(QUICK)
    workspace.runs.store_results(session, list(complete(session.frame, session.labels, QUICK).results.values()))
    workspace.parameters.set_own({"s_criteria": 0.002}, [2])
    for label, line in ((1, "S_criteria 0.5 mm"), (2, "S_criteria 2 mm (own, run used 0.5 mm)")):
        workspace.blocks.select([label])
        presenter.show()
        assert panel._criteria.texts == [line]
        own = session.parameters_of(label)
        form.show_parameters(own, session.state.common, [session.info(label).name])
        assert form.form.parameters().s_criteria == panel._curves[0].s_criteria
    workspace.runs.store_results(
        session, list(complete(session.frame, session.labels, QUICK.replace(s_criteria=0.002)).results.values())
    )
    presenter.show()
    assert panel._criteria.texts == ["S_criteria 2 mm (own)"]
    workspace.blocks.select([1, 2])
    presenter.show()
    assert panel._criteria.texts == ["S_criteria 0.5 mm", "S_criteria 2 mm (own)"]

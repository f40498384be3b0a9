"""Which curves are shown, and that the line of the criterion says what the very block has."""

import numpy as np
import pytest

import ilf
from gui.features.curves import draw_curves
from gui.views.curves.panel import CurvesPanel
from ilf.data.results import IterationRecord
from ilf.project.run_history import StoredRun

QUICK = ilf.preset(max_iterations=5)


@pytest.fixture
def panel(shown):
    return shown(CurvesPanel(), 700, 400)


@pytest.fixture
def show(workspace, panel):
    return lambda: draw_curves(panel, workspace.shown)


def names(panel):
    rows = panel.readout.text.splitlines()
    return [row.split("   ")[0].removesuffix(": not converged") for row in rows]


def test_the_chosen_blocks_are_shown_else_the_one_that_runs_else_the_longest(workspace, panel, show, results):
    show()
    assert names(panel) == []
    workspace.current.store_results(results)
    show()
    assert names(panel) == ["Block 1"]
    workspace.current.add_records(2, [IterationRecord(1, 1, 0.1, 1.0, 0.0, np.nan, 0.0)])
    show()
    assert names(panel) == ["Block 2"]
    assert "i 1 " in panel.readout.text
    workspace.select([2, 1])
    show()
    assert names(panel) == ["Block 2", "Block 1"]
    workspace.select([1])
    show()
    assert names(panel) == ["Block 1"]
    workspace.show(None)
    show()
    assert names(panel) == []


def test_compared_runs_are_shown_beside_the_present_result(workspace, document, panel, show, results):
    document.store_results(results)
    workspace.select([1])
    other = ilf.complete(document.frame, document.labels, ilf.preset("paper", max_iterations=12)).results
    kept = StoredRun(1, "Run 1", document.run(document.state.common), other, 1.0, (200, 0, 0))
    document.keep_run(kept)
    workspace.current.compare_runs([kept])
    show()
    assert names(panel) == ["Block 1", "Run 1"]
    assert [curve.dashed for curve in panel._curves] == [False, True]
    assert panel.sigma_plot.lines[1].getData()[0][-1] == len(other[1].history)
    workspace.select([1, 2])
    show()
    assert names(panel) == ["Block 1", "Block 2", "Run 1: Block 1", "Run 1: Block 2"]


def criteria(panel):
    return [line.label.toPlainText() for line in panel.sigma_plot.labels]


def test_the_criterion_is_that_of_the_block(workspace, document, panel, show):
    workspace.parameters.set(QUICK)
    document.store_results(list(ilf.complete(document.frame, document.labels, QUICK).results.values()))
    workspace.parameters.set_own({"s_criteria": 0.002}, [2])
    for label, line in ((1, "S_criteria 0.5 mm"), (2, "S_criteria 2 mm (own, run used 0.5 mm)")):
        workspace.select([label])
        show()
        assert criteria(panel) == [line]
        assert document.parameters_of(label).s_criteria == panel._curves[0].s_criteria
    document.store_results(
        list(ilf.complete(document.frame, document.labels, QUICK.replace(s_criteria=0.002)).results.values())
    )
    show()
    assert criteria(panel) == ["S_criteria 2 mm (own)"]
    workspace.select([1, 2])
    show()
    assert criteria(panel) == ["S_criteria 0.5 mm", "S_criteria 2 mm (own)"]

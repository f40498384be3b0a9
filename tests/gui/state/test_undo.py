"""What undo takes back and brings back beside pixels: parameters, results, drawn borders, distrusted depth."""

import numpy as np
import pytest

import ilf
from gui.state.document import Document
from gui.state.parts import Part
from ilf.data.results import compose
from ilf.errors import InputError
from ilf.segmentation.extraction import extract

from ..states import QUICK, edit, extraction


def test_what_has_been_run_since_results_were_cleared_stays_when_they_come_back(workspace, document, results):
    document.store_results(results)
    workspace.current.clear_results()
    newer = ilf.complete(document.frame, document.labels, QUICK.replace(max_iterations=3)).results[1]
    document.store_results([newer])
    document.undo_stack.undo()
    assert document.valid_results() == {1: newer, 2: results[1]}
    document.undo_stack.redo()
    assert document.valid_results() == {}
    document.undo_stack.undo()
    assert document.valid_results() == {1: newer, 2: results[1]}


def test_the_present_depth_is_that_of_the_completion_whatever_happens(workspace, document, results):
    """What is kept up to date box by box is what would be made anew."""
    random = np.random.default_rng(0)
    document.change(common=QUICK)
    document.store_results(results)
    for _ in range(30):
        rows, columns = (sorted(random.choice(40, 2, replace=False)) for _ in range(2))
        edit(
            workspace, int(random.integers(0, 4)), rows=np.s_[rows[0] : rows[1]], columns=np.s_[columns[0] : columns[1]]
        )
        if random.random() < 0.5:
            wanted = document.changed_blocks()[:2]
            done = document.run(QUICK, wanted).complete()
            document.store_results(list(done.results.values()))
        for _ in range(random.integers(0, 3)):
            document.undo_stack.undo()
        fresh = compose(document.run(QUICK), document.valid_results())
        np.testing.assert_array_equal((document.completion() or fresh).depth, fresh.depth)
        shown = np.where(document.stale, fresh.depth, document.current_depth())
        np.testing.assert_array_equal(shown, fresh.depth)
        assert not np.isin(document.labels, [0, *document.valid_results()])[document.stale].any()
        document._tally, counts = None, document.counts()
        assert document.counts() == counts


def test_borders_that_come_by_an_edit_are_drawn_ones(workspace, document):
    assert document.run(QUICK).blocks.drawn is None
    edit(workspace, 3)
    drawn = document.run(QUICK).blocks.drawn
    np.testing.assert_array_equal(
        drawn[:6, :7],
        np.array(
            [[False] * 4 + [True] * 2 + [False]] * 3
            + [[True] * 5 + [True, False], [True] * 5 + [False] * 2, [False] * 7]
        ),
    )
    assert not drawn[:, 28:].any(), "extracted borders stay what they are"
    document.undo_stack.undo()
    assert document.run(QUICK).blocks.drawn is None
    document.undo_stack.redo()
    np.testing.assert_array_equal(document.run(QUICK).blocks.drawn, drawn)
    again = Document.of(document.run(QUICK), "run.json", "run.json")
    np.testing.assert_array_equal(again.run(QUICK).blocks.drawn, drawn)
    fresh = np.full(document.frame.shape, 7, np.int32)
    document.set_extracted(extraction(document, fresh), ilf.BlockParameters(), keep_handmade=True)
    kept = document.labels == 3
    np.testing.assert_array_equal(document.blocks.drawn, drawn & kept)
    workspace.current.replace_blocks(fresh, "Load blocks")
    assert document.run(QUICK).blocks.drawn is None


def test_depth_that_is_distrusted_is_missing_and_undo_brings_it_back(workspace, document, results, told):
    document.store_results(results)
    mask = np.zeros(document.frame.shape, bool)
    mask[30:40, 5:20] = True
    told()
    assert workspace.current.set_invalid_mask(mask, "Distrust depth")
    assert not workspace.current.set_invalid_mask(mask.copy(), "Distrust depth")
    assert told() == Part.INVALID_MASK | Part.RESULTS
    assert np.isnan(document.frame.depth[mask]).all()
    assert document.counts()[1].known == (document.frame.known & (document.labels == 1)).sum()
    assert document.valid_results() == {}
    document.undo_stack.undo()
    assert document.frame.invalid_mask is None
    assert list(document.valid_results()) == [1, 2]
    with pytest.raises(InputError, match="no known depth is left"):
        workspace.current.set_invalid_mask(np.ones_like(mask), "Distrust depth")
    assert document.frame.invalid_mask is None


def test_results_go_with_the_extraction_whose_edges_the_filter_saw(workspace, document):
    """Blocks that stay have the same pixels, but other edges: a run of them would not give the same result."""
    for label in (1, 2):
        workspace.current.set_lock(label, True)
    jumps, pieces = ilf.BlockParameters(depth_jump=0.5), ilf.BlockParameters(granularity=0.9)
    document.add_results(list(ilf.complete(document.frame, document.labels, ilf.preset()).results.values()))
    assert set(document.valid_results()) == {1, 2}
    found = extract(document.frame, pieces)
    document.set_extracted(found, pieces, keep_handmade=True)
    assert set(document.valid_results()) == {1, 2}, "the edges are the same"
    document.set_extracted(found, jumps, keep_handmade=True)
    assert document.valid_results() == {}
    assert document.completion() is None
    paper = ilf.complete(document.frame, document.labels, ilf.preset("paper", max_iterations=5), extraction=jumps)
    document.add_results(list(paper.results.values()))
    document.set_extracted(found, ilf.BlockParameters(), keep_handmade=True)
    assert set(document.valid_results()) == {1, 2}, "the pass band knows no edges"


def test_a_new_extraction_flows_around_what_stays(document):
    own = {"smoothness": 2.0}
    document.change_info(1, name="Floor", locked=True)
    document.change_blocks(own={1: own, 2: own})
    used = ilf.BlockParameters(granularity=0.2)
    fresh = np.full(document.frame.shape, 7, np.int32)
    fresh[:24] = 5
    before = document.labels.copy()
    assert document.set_extracted(extraction(document, fresh), used, keep_handmade=True) == (1, 0, False)
    np.testing.assert_array_equal(document.labels == 1, before == 1)
    assert len(document.counts()) == 3
    assert document.undo_stack.undoText() == "Extract blocks"
    assert document.blocks.extraction == used
    assert document.blocks.edited, "one block was kept"
    assert document.blocks.kept == {1}
    assert document.handmade() == set(), "a block that only was locked is not made by hand"
    assert document.info(1).name == "Floor"
    assert document.blocks.own == {1: own}
    document.undo_stack.undo()
    np.testing.assert_array_equal(document.labels, before)
    assert document.blocks.own == {1: own, 2: own}
    assert document.blocks.extraction == ilf.BlockParameters()

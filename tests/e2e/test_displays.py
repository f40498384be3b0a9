"""What the window shows over the pictures, by its commands."""

import numpy as np
import pytest


def test_shuffled_colours_are_one_step_and_all_others_and_names_follow_the_blocks(opened, monkeypatch):
    monkeypatch.setattr("random.randrange", lambda *_: 1)  # blocks 1 and 2 have the first two colours
    document = opened.workspace.current
    before = {label: document.info(label).colour for label in document.counts()}
    opened.actions_["shuffle_colours"].trigger()
    after = {label: document.info(label).colour for label in document.counts()}
    assert all(after[label] != before[label] for label in before)
    assert len(set(after.values())) == len(after)
    opened.refresh.now()
    assert tuple(opened.views.blocks.colours[1, :3]) == after[1]
    opened.actions_["undo"].trigger()
    assert {label: document.info(label).colour for label in before} == before
    assert not document.undo_stack.canUndo()

    names = opened.views.cells["colour"].view.names
    opened.actions_["block_names"].trigger()
    opened.refresh.now()
    assert sorted(names.texts) == ["Block 1", "Block 2"]
    opened.workspace.current.edit_info(1, "Rename block", name="Wall")
    opened.refresh.now()
    assert sorted(names.texts) == ["Block 2", "Wall"]
    opened.workspace.select([1, 2])
    opened.actions_["merge_blocks"].trigger()
    opened.refresh.now()
    assert len(names.texts) == 1
    opened.actions_["block_names"].trigger()
    opened.refresh.now()
    assert names.texts == []


def test_one_click_fits_the_colours_to_the_selection_or_to_what_is_visible(opened):
    views, fit = opened.views, opened.actions_["fit_range"]
    depth = opened.workspace.current.frame.depth
    fit.trigger()
    assert views.ranges.depth == pytest.approx(np.nanpercentile(depth, (1, 99)))
    views.transform.show(slice(2, 8), slice(4, 12))
    opened.refresh.now()
    fit.trigger()
    assert np.nanmin(depth[:, :30]) <= views.ranges.depth[0] < views.ranges.depth[1] <= np.nanmax(depth[:, :30])
    right = int(opened.workspace.current.labels[5, 60])
    opened.workspace.select([right])
    fit.trigger()
    chosen = depth[opened.workspace.current.labels == right]
    assert views.ranges.depth == pytest.approx(np.nanpercentile(chosen, (1, 99)))

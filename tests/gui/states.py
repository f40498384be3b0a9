"""Parameters, edits and extractions for tests of the window's state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.data.blocks import own_values
from ilf.data.presets import preset
from ilf.segmentation.editing.patches import patch_between
from ilf.segmentation.extraction import Extraction, extract

QUICK = preset("paper", max_iterations=2)
QUICK_OWN = own_values(QUICK, preset())
SIGNALS = (
    *(
        "blocks.about_to_change",
        "frames.sessions_changed",
        "frames.session_changed",
        "blocks.labels_changed",
        "blocks.stroke_changed",
        "blocks.infos_changed",
    ),
    *(
        "runs.results_changed",
        "runs.results_added",
        "runs.records_added",
        "runs.previews_changed",
        "runs.error_changed",
        "blocks.selection_changed",
    ),
    *("parameters.changed", "parameters.extraction_changed", "blocks.invalid_mask_changed"),
)


def painted(session: Session, label: int, rows: slice = np.s_[0:4], columns: slice = np.s_[0:5]) -> np.ndarray:
    """The label map with a box of another label."""
    labels = session.labels.copy()
    labels[rows, columns] = label
    return labels


def edit(workspace: Workspace, label: int, **box: slice) -> bool:
    labels = workspace.session.labels
    return workspace.blocks.edit(patch_between(labels, painted(workspace.session, label, **box)), "Edit")


def extraction(session: Session, labels: np.ndarray) -> Extraction:
    """One that gives these blocks."""
    return replace(extract(session.frame), blocks=labels.copy())

"""Parameters, edits and extractions for tests of the window's state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.data.parameters import preset
from ilf.project.frame_state import own_values
from ilf.segmentation.editing.patches import patch_between
from ilf.segmentation.extraction import Extraction, extract

QUICK = preset("paper", max_iterations=2)
QUICK_OWN = own_values(QUICK, preset())
SIGNALS = (
    *("about_to_change", "sessions_changed", "session_changed", "labels_changed", "stroke_changed", "infos_changed"),
    *("results_changed", "results_added", "records_added", "previews_changed", "error_changed", "selection_changed"),
    *("parameters_changed", "extraction_changed", "invalid_mask_changed"),
)


def painted(session: Session, label: int, rows: slice = np.s_[0:4], columns: slice = np.s_[0:5]) -> np.ndarray:
    """The label map with a box of another label."""
    labels = session.labels.copy()
    labels[rows, columns] = label
    return labels


def edit(workspace: Workspace, label: int, **box: slice) -> bool:
    labels = workspace.session.labels
    return workspace.edit_labels(patch_between(labels, painted(workspace.session, label, **box)), "Edit")


def extraction(session: Session, labels: np.ndarray) -> Extraction:
    """One that gives these blocks."""
    return replace(extract(session.frame), blocks=labels.copy())

"""Parameters, edits and extractions for tests of the window's state."""

from dataclasses import replace

import numpy as np

from gui.state.document import Document
from gui.state.parts import NO_PART, Part
from gui.state.workspace import Workspace
from ilf.data.presets import preset
from ilf.segmentation.editing.patches import patch_between
from ilf.segmentation.extraction import Extraction, extract

QUICK = preset("paper", max_iterations=2)
QUICK_OWN = QUICK.differences_from(preset())


class Told:
    """Calling it gives what a workspace has told since the last call, but for `CONTENT`, which every edit changes."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._parts = NO_PART
        workspace.tell()
        workspace.changed.connect(self._take)

    def _take(self, parts: Part) -> None:
        self._parts |= parts

    def __call__(self) -> Part:
        self._workspace.tell()
        parts, self._parts = self._parts, NO_PART
        return parts & ~Part.CONTENT


def painted(document: Document, label: int, rows: slice = np.s_[0:4], columns: slice = np.s_[0:5]) -> np.ndarray:
    """The label map with a box of another label."""
    labels = document.labels.copy()
    labels[rows, columns] = label
    return labels


def edit(workspace: Workspace, label: int, **box: slice) -> bool:
    labels = workspace.current.labels
    return workspace.current.edit(patch_between(labels, painted(workspace.current, label, **box)), "Edit")


def extraction(document: Document, labels: np.ndarray) -> Extraction:
    """One that gives these blocks."""
    return replace(extract(document.frame), blocks=labels.copy())

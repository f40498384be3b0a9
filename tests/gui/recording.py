"""What a window has of the autosave, without its widgets."""

import shutil
from pathlib import Path

import numpy as np

import ilf
from gui.project.recorder import Recorder
from gui.project.store import WorkStore
from gui.state.document import Document
from gui.state.workspace import Workspace
from ilf.project.state_codec import load_state
from ilf.project.store import WorkFolder
from ilf.segmentation.editing.patches import patch_between


class Recording:
    """Two frames that are open, a store and a recorder. Copies of the autosave are made in a folder aside."""

    def __init__(self, folder: Path, aside: Path, frame: ilf.RGBDFrame, labels: np.ndarray) -> None:
        self.folder, self.aside = folder, aside
        self.workspace = Workspace()
        self.store = WorkStore(folder)
        self.recorder = Recorder(self.workspace, self.store)
        self.recorder.start()
        self.documents = [Document.of(ilf.Run(frame, labels), None, name) for name in ("one", "two")]
        for document in self.documents:
            self.workspace.open_document(document)

    def erase(self, document: Document, row: int) -> None:
        """Take a row from the blocks."""
        self.workspace.show(document)
        labels = document.labels.copy()
        labels[row] = 0
        self.workspace.current.edit(patch_between(document.labels, labels), "Erase")

    def written(self) -> WorkFolder:
        """The autosave as another program finds it after this one's end."""
        (path,) = self.folder.glob("*.work")
        shutil.rmtree(self.aside, ignore_errors=True)
        shutil.copytree(self.folder, self.aside)
        return WorkFolder(self.aside / path.name)

    def assert_written(self, *documents: Document) -> None:
        """The newest states of these are in the autosave."""
        written = self.written()
        for document in documents:
            assert_holds(written, document)
        written.discard()

    def end(self) -> None:
        """As a window that is closed."""
        assert self.recorder.shutdown()
        self.store.discard()


def assert_holds(parts: WorkFolder, document: Document) -> None:
    """The newest state of a frame is in an autosave."""
    decoded = load_state(document.id, parts)
    assert decoded.problems == ()
    assert np.array_equal(decoded.state.blocks.labels, document.labels)
    assert {label: info.name for label, info in decoded.state.blocks.infos.items()} == {
        label: info.name for label, info in document.blocks.infos.items()
    }

"""Why commands cannot be used."""

from __future__ import annotations

from types import SimpleNamespace

from gui.base.needs import Need, sentence
from gui.features.context import Reasons
from gui.state.document import Document
from gui.state.workspace import Workspace


def test_the_first_thing_that_a_command_lacks_is_named(workspace: Workspace, document: Document) -> None:
    reasons = Reasons(workspace, SimpleNamespace(free=True), SimpleNamespace(busy=False))

    def told() -> tuple[str, str, str]:
        missing = reasons.missing()
        blocks, selection, unlocked = (
            sentence(need & missing) for need in (Need.BLOCKS, Need.SELECTION, Need.UNLOCKED)
        )
        return blocks, selection, unlocked

    assert told() == ("", "Select a block first.", "Select a block first.")
    workspace.select([1])
    assert told() == ("", "", "")
    workspace.current.set_lock(1, True)
    assert told() == ("", "", "The selected blocks are locked: unlock them first.")
    document.labels[:] = 0
    document.set_labels(document.labels)
    assert told() == ("There are no blocks: extract or draw some first.",) * 3
    empty = Reasons(Workspace(), SimpleNamespace(free=True), SimpleNamespace(busy=False))
    assert sentence(Need.UNLOCKED & empty.missing()) == "Open a frame first."
    empty.playing = True
    assert sentence(Need.FRAME & empty.missing()) == "Pause playing first."

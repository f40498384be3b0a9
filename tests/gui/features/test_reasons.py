"""Why commands cannot be used."""

from __future__ import annotations

from types import SimpleNamespace

from gui.features.context import Reasons
from gui.state.session import Session
from gui.state.workspace import Workspace


def test_the_first_thing_that_a_command_lacks_is_named(workspace: Workspace, session: Session) -> None:
    reasons = Reasons(workspace, SimpleNamespace(free=True), SimpleNamespace(busy=False))

    def told() -> tuple[str, str, str]:
        reasons.update()
        return reasons.no_blocks(), reasons.none_selected(), reasons.locked()

    assert told() == ("", "Select a block first.", "Select a block first.")
    workspace.blocks.select([1])
    assert told() == ("", "", "")
    workspace.blocks.set_lock(1, True)
    assert told() == ("", "", "The selected blocks are locked: unlock them first.")
    session.labels[:] = 0
    session.set_labels(session.labels)
    assert told() == ("There are no blocks: extract or draw some first.",) * 3
    assert Reasons(Workspace(), SimpleNamespace(), SimpleNamespace()).locked() == "Open a frame first."

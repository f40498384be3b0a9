"""Parameters for all frames, or for one of them."""

import pytest

import ilf
from gui.state.document import Document
from gui.state.parameters import SharedParameters
from gui.state.parts import Part
from gui.state.workspace import Workspace

from ..states import Told


def smoothness(*documents: Document) -> list[float]:
    return [document.state.common.smoothness for document in documents]


def set_smoothness(workspace, value: float):
    workspace.parameters.set(workspace.parameters.current.replace(smoothness=value))


@pytest.fixture
def shared(workspace):
    """Both frames have the values of all."""
    workspace.parameters.share()
    return workspace


def test_results_of_other_values_are_out_of_date_in_all_frames_until_they_are_back(
    workspace, document, other, small_labels
):
    def run():
        other.store_results(list(ilf.complete(other.frame, small_labels, other.state.common).results.values()))

    for frame, iterations in ((other, 2), (document, 3)):
        workspace.show(frame)
        workspace.parameters.set(ilf.preset("paper", max_iterations=iterations))
    run()
    assert workspace.parameters.share() == [other]
    assert not other.is_up_to_date(1)
    run()
    assert other.is_up_to_date(1)
    document.undo_stack.undo()
    assert not workspace.parameters.shared.on
    assert other.is_up_to_date(1)
    document.undo_stack.redo()
    workspace.parameters.set(document.state.common.replace(s_criteria=0.002))
    assert not other.is_up_to_date(1)


def test_a_frame_that_is_opened_as_it_was_stored_has_the_values_of_all_or_its_own(shared, small_frame, small_labels):
    set_smoothness(shared, 3.0)
    opened = [Document.of(ilf.Run(small_frame, small_labels), name, name) for name in ("one", "two")]
    opened[1].change(own_parameters=True)
    for document in opened:
        document.change(common=ilf.Parameters(smoothness=9.0))
        shared.open_document(document, restored=True, show=False)
    assert smoothness(*opened) == [3.0, 9.0]


def test_a_project_says_which_they_are_before_its_frames_are_opened(small_frame, small_labels, qapp):
    workspace = Workspace()
    told = Told(workspace)
    workspace.parameters.set_shared(SharedParameters(True, ilf.Parameters(smoothness=4.0)))
    assert Part.PARAMETERS in told()
    document = Document.of(ilf.Run(small_frame, small_labels), "origin", "key")
    workspace.open_document(document, restored=True)
    assert workspace.parameters.current.smoothness == 4.0
    workspace.show(None)
    assert workspace.parameters.current.smoothness == 4.0

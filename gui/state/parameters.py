"""Filter and extraction parameters of the documents, shared by all frames or separate for each, and their commands.

While they are shared, a change is one undo step of the frame where it was made. Undoing it restores the former values
in all frames, even if they were changed from another frame since: all frames without own parameters always have the
same ones.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import OwnValues
from ilf.data.parameters import DEFAULT_PRESET, BlockParameters, Parameters
from ilf.data.presets import preset
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from .document import Document
from .parts import Part, Swap

if TYPE_CHECKING:
    from .workspace import Workspace

DRAG_S = 0.7
"""Changes of the same parameters within this time [s] are one undo step."""


class SharedParameters(NamedTuple):
    """Whether parameters are shared by all frames, and the shared parameters."""

    on: bool
    values: Parameters
    """The next frame starts with these, whether they are shared or not."""

    def applies_to(self, document: Document) -> bool:
        """Whether a frame has the shared parameters."""
        return self.on and not document.state.own_parameters

    def apply_to(self, documents: Iterable[Document], transient: bool = False) -> None:
        """Set the shared parameters in frames without own ones; with `transient`, undo does not lead back."""
        for document in documents:
            if self.applies_to(document) and document.state.common != self.values:
                if not transient:
                    document.remember_parameters()
                document.change(common=self.values)


_Sharing = tuple[SharedParameters, Parameters, bool, WeakKeyDictionary[Document, Parameters] | None]
"""Whether parameters are shared, those of a frame, and whether they are its own; to undo a change, also those of all
frames before it."""


class DocumentParameters:
    """The parameters of all frames, of one frame, or of blocks."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.shared = SharedParameters(False, preset(DEFAULT_PRESET))
        """Whether parameters are shared, and which; if not, a new frame starts with those of the current frame."""
        self.extraction = BlockParameters()
        """The parameters of the next extraction."""
        self.keeps_handmade = True
        """Whether a new extraction keeps hand-made blocks, as it keeps locked ones."""

    @property
    def current(self) -> Parameters:
        """Common parameters of the current frame: those of all blocks without own parameters."""
        return self._workspace.shown.state.common if self._workspace.shown is not None else self.shared.values

    @property
    def for_all(self) -> Parameters | None:
        """The parameters that all frames share, if any."""
        return self.shared.values if self.shared.on else None

    @property
    def of_next_frame(self) -> Parameters:
        """Parameters that the next frame starts with."""
        return self.for_all or self.current

    def leave(self) -> None:
        """Remember the parameters of the current frame for the next one; called before another one is shown."""
        self.shared = self.shared._replace(values=self.of_next_frame)

    def start(self, document: Document, recorded: Run | None = None, restored: bool = False) -> None:
        """Set the parameters of a frame that is about to be opened: those of the next frame, or of a recorded run.

        A `restored` frame keeps its own, unless it shares them.
        """
        if restored:
            self.shared.apply_to([document], transient=True)
        else:
            document.change(common=self.of_next_frame)
        if recorded is None:
            return
        own_parameters = self.shared.on and recorded.parameters != self.shared.values
        document.change(common=recorded.parameters, own_parameters=own_parameters)
        if recorded.blocks.extraction is not None:
            self.set_extraction(recorded.blocks.extraction)
        labels = document.counts() if recorded.only is None else recorded.only
        own = {label: recorded.parameters_of(label).differences_from(recorded.parameters) for label in labels}
        document.change_blocks(
            own={**document.blocks.own, **{label: values for label, values in own.items() if values}}
        )

    def set(self, parameters: Parameters, blocks: int | Collection[int] | None = None) -> None:
        """Set the common parameters, or those of some blocks, as one undo step.

        For blocks, the values that differ from the common ones become own parameters. Values set while a slider moves
        belong to the same step.
        """
        values = parameters.differences_from(self.current)
        if blocks is None:
            self._edit(values, {})
        else:
            self._edit({}, dict.fromkeys([blocks] if isinstance(blocks, int) else blocks, values))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Add own parameters to blocks; values equal to the common ones are removed."""
        common, own = self.current.to_dict(), self._workspace.current.blocks.own

        def own_values(label: int) -> OwnValues:
            merged = {**own.get(label, {}), **values}
            return {name: value for name, value in merged.items() if value != common[name]}

        self._edit({}, {label: own_values(label) for label in blocks})

    def reset_own(self, blocks: Collection[int]) -> None:
        """Remove all own parameters from blocks."""
        self._edit({}, {label: {} for label in blocks})

    def copy_own(self, source: int, blocks: Collection[int]) -> None:
        """Copy the own parameters of a block to others."""
        self._edit({}, dict.fromkeys(blocks, self._workspace.current.blocks.own.get(source, {})))

    def _edit(self, common: OwnValues, own: Mapping[int, OwnValues]) -> None:
        """Set common parameters, and all own parameters of blocks, as one undo step, or as part of the last one."""
        if (document := self._workspace.shown) is None:
            if common:
                self.set_shared(self.shared._replace(values=self.shared.values.replace(**common)))
            return
        step, stack = EditParameters(self, document, common, own), document.undo_stack
        if not step.names:
            return
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(step):
            document.note_edit()
            return
        count = len(step.names)
        what = parameter_labels(step.names)[0] if count == 1 else f"{count} filter parameters"
        labels = step.blocks
        blocks = f" of {document.info(min(labels)).name}" if len(labels) == 1 else f" of {len(labels)} blocks"
        step.setText(f"Set {what}{blocks if labels else self.all_frames_text(document)}")
        stack.push(step)

    def all_frames_text(self, document: Document) -> str:
        """Return the end of the text of an undo step on a frame's common parameters."""
        return " for all frames" if self.shared.applies_to(document) else ""

    def take(
        self, document: Document, common: OwnValues, own: Mapping[int, OwnValues], transient: bool = False
    ) -> None:
        """Set some of the common parameters and all own parameters of blocks. Called by commands.

        With `transient`, undo does not lead back to the present ones.
        """
        before = document.valid_results()
        if not transient:
            document.remember_parameters()
        if own:
            merged = {**document.blocks.own, **own}
            document.change_blocks(own={label: values for label, values in merged.items() if values})
        document.change(common=document.state.common.replace(**common))
        if common and self.shared.applies_to(document):
            self.shared = SharedParameters(True, document.state.common)
            self.shared.apply_to(self._workspace.open, transient)
            self._workspace.project_touched.emit()
        document.note(Part.PARAMETERS)
        if document.valid_results() != before:  # results of earlier parameters are valid again
            document.note(Part.RESULTS)

    def take_common(self, document: Document, common: Parameters, own: bool) -> None:
        """Set a frame's common parameters, unless it has the shared ones. Called by commands.

        With `own`, they are its own while parameters are shared by all frames.
        """
        document.change(common=common, own_parameters=own)
        self.shared.apply_to([document], transient=True)
        document.note(Part.PARAMETERS)

    def set_shared(self, shared: SharedParameters) -> None:
        """Set whether parameters are shared by all frames, and which; also on loading a project, before its frames."""
        former, self.shared = self.shared, shared
        shared.apply_to(self._workspace.open)
        if former.on and not shared.on:  # from now on they are stored with each frame
            for document in self._workspace.open:
                if document.counts() or document.unsaved:
                    self._workspace.touch(document)
        self._workspace.touch_project(Part.PARAMETERS)

    def share(self) -> list[Document]:
        """Share the current frame's parameters with all frames without own ones, as one undo step.

        Returns the open frames that had other parameters.
        """
        shared = SharedParameters(True, self.current)
        others = [
            one for one in self._workspace.open if not one.state.own_parameters and one.state.common != self.current
        ]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return others

    def keep_own(self) -> None:
        """Give the current frame its own parameters while others are shared, as one undo step."""
        self._push_sharing(self.shared, own=True, text="Use parameters for this frame only")

    def reset_to_shared(self) -> None:
        """Reset the current frame to the shared parameters, as one undo step."""
        self._push_sharing(self.shared, own=False, text="Reset to shared parameters")

    def separate(self) -> None:
        """Stop sharing parameters: every frame keeps its current ones as its own, as one undo step."""
        self._push_sharing(SharedParameters(False, self.current), own=False, text="Separate parameters for each frame")

    def _push_sharing(self, shared: SharedParameters, own: bool, text: str) -> None:
        """Change whether parameters are shared, as one undo step; undo restores the parameters of the other frames."""
        workspace, document = self._workspace, self._workspace.current

        def exchange(to: _Sharing) -> _Sharing:
            shared, common, own, undone = to
            former = self.shared, document.state.common, document.state.own_parameters
            others = WeakKeyDictionary({one: one.state.common for one in workspace.open})
            results = document.valid_results()
            document.remember_parameters()
            document.change(common=common, own_parameters=own)
            self.set_shared(shared)
            workspace.note(Part.LIST)
            if document.valid_results() != results:
                document.note(Part.RESULTS)
            if undone is not None and not shared.on:
                for one, common in undone.items():
                    if one in workspace.open and one.state.common != common:
                        one.remember_parameters()
                        one.change(common=common)
            for one in workspace.open if former[0].on and not shared.on else ():
                # its parameters are now stored with it; restoring an earlier state is no unsaved change
                if one is not document and not one.state.own_parameters:
                    one.touch(viewing=undone is not None)
            return *former, others if undone is None else None

        common = document.state.common if own or not shared.on else shared.values
        to: _Sharing = shared, common, own, None
        document.undo_stack.push(Swap(text, to, exchange))

    def restore(self, kept: StoredRun) -> bool:
        """Restore common and own parameters of a stored run in the current frame, as one undo step; False if they are
        the current ones."""
        document, run = self._workspace.current, kept.run
        there = set(document.counts()).intersection(np.unique(run.blocks.labels).tolist())
        own = {label: run.parameters_of(label).differences_from(run.parameters) for label in there}
        step = EditParameters(self, document, run.parameters.differences_from(document.state.common), own)
        if not step.names:
            return False
        step.setText(f"Restore parameters of {kept.name}{self.all_frames_text(document)}")
        document.undo_stack.push(step)
        return True

    def set_extraction(self, parameters: BlockParameters) -> None:
        """Set the parameters of the next extraction."""
        self.extraction = parameters
        self._workspace.touch_project(Part.EXTRACTION)

    def set_keeps_handmade(self, on: bool) -> None:
        """Set whether the next extraction keeps hand-made blocks."""
        self.keeps_handmade = on
        self._workspace.touch_project(Part.EXTRACTION)


class EditParameters(QUndoCommand):
    """A change of common parameters, or of own parameters of blocks.

    Parameters
    ----------
    common : mapping of str to Value
        New values of common parameters.
    own : mapping of int to OwnValues
        Block label -> all own parameters that it gets.

    Attributes
    ----------
    names : set of str
        The parameters that change.
    """

    def __init__(
        self, host: DocumentParameters, document: Document, common: OwnValues, own: Mapping[int, OwnValues]
    ) -> None:
        super().__init__()
        self._host = host
        self._document = document
        former = {label: document.blocks.own.get(label, {}) for label in own}
        changed = {label: values for label, values in own.items() if values != former[label]}
        present = document.state.common.to_dict()
        self._after = common, changed
        self._before = {name: present[name] for name in common}, {label: former[label] for label in changed}
        pairs = ((former[label].items(), changed[label].items()) for label in changed)
        self.names = {*common}.union(*({name for name, _ in one ^ other} for one, other in pairs))
        self._time = time.monotonic()

    @property
    def blocks(self) -> Collection[int]:
        """The blocks whose own parameters change."""
        return self._after[1].keys()

    def extend(self, further: EditParameters) -> bool:
        """Extend the step by new values of the same parameters if they follow quickly, as from a moving slider.

        False if they do not.
        """
        what, others = ((step.names, step.blocks, step._after[0].keys()) for step in (self, further))
        if what != others or further._time - self._time > DRAG_S:
            return False
        self._after, self._time = further._after, further._time
        self._host.take(self._document, *self._after, transient=True)
        return True

    def redo(self) -> None:
        """Apply the change."""
        self._host.take(self._document, *self._after)

    def undo(self) -> None:
        """Undo the change."""
        self._host.take(self._document, *self._before)


def parameter_labels(names: Iterable[str]) -> list[str]:
    """Return the labels of parameters, in the order in which they are declared."""
    declarations = Parameters.declarations()
    return [declarations[name].label for name in declarations if name in set(names)]

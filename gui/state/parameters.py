"""Filter and extraction parameters of the documents, shared by all frames or separate for each, and their commands.

While they are shared, a change is one undo step of the frame where it was made. Undoing it restores the former values
in all frames, even if they were changed from another frame since: all frames without own parameters always have the
same ones.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import OwnValues
from ilf.data.parameters import DEFAULT_PRESET, BlockParameters, Parameters
from ilf.data.presets import preset
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from .document import Document
from .edits import Swap
from .frames import Frames
from .parts import Part

OwnChange = Mapping[int, tuple[OwnValues | None, OwnValues | None]]
"""Block label -> its own parameters before and after, None for none."""

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

    def apply_to(self, document: Document) -> None:
        """Set the shared parameters in a restored frame, unless it has its own."""
        if self.applies_to(document):
            document.change(common=self.values)

    def apply_to_all(self, documents: Iterable[Document], transient: bool = False) -> None:
        """Set the shared parameters in all frames without own ones; with `transient`, undo does not lead back."""
        for document in documents:
            if self.applies_to(document) and document.state.common != self.values:
                if not transient:
                    document.remember_parameters()
                document.change(common=self.values)


class _Sharing(NamedTuple):
    """Whether parameters are shared, those of a frame, and whether they are its own; to undo a change, also those of
    all frames before it."""

    shared: SharedParameters
    common: Parameters
    own: bool
    others: WeakKeyDictionary[Document, Parameters] | None = None


class DocumentParameters:
    """The parameters of all frames, of one frame, or of blocks."""

    def __init__(self, frames: Frames) -> None:
        self._frames = frames
        self.shared = SharedParameters(False, preset(DEFAULT_PRESET))
        """Whether parameters are shared, and which; if not, a new frame starts with those of the current frame."""
        self.extraction = BlockParameters()
        """The parameters of the next extraction."""
        self.keeps_handmade = True
        """Whether a new extraction keeps hand-made blocks, as it keeps locked ones."""

    @property
    def current(self) -> Parameters:
        """Common parameters of the current frame: those of all blocks without own parameters."""
        return self._frames.current.state.common if self._frames.has_current else self.shared.values

    @property
    def of_next_frame(self) -> Parameters:
        """Parameters that the next frame starts with."""
        return self.shared.values if self.shared.on else self.current

    def leave(self) -> None:
        """Remember the parameters of the current frame for the next one; called before another one is shown."""
        self.shared = SharedParameters(self.shared.on, self.of_next_frame)

    def start(self, document: Document, recorded: Run | None = None, restored: bool = False) -> None:
        """Set the parameters of a frame that is about to be opened: those of the next frame, or of a recorded run.

        A `restored` frame keeps its own, unless it shares them.
        """
        if restored:
            self.shared.apply_to(document)
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
        if blocks is None:
            self._edit((self.current, parameters), {}, parameters.differences_from(self.current).keys())
            return
        labels = [blocks] if isinstance(blocks, int) else blocks
        self._edit_own(dict.fromkeys(labels, parameters.differences_from(self.current)))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Add own parameters to blocks; values equal to the common ones are removed."""
        common, own = self.current.to_dict(), self._frames.current.blocks.own
        merged = {label: {**own.get(label, {}), **values} for label in blocks}
        self._edit_own(
            {
                label: {name: value for name, value in one.items() if value != common[name]}
                for label, one in merged.items()
            }
        )

    def reset_own(self, blocks: Collection[int]) -> None:
        """Remove all own parameters from blocks."""
        self._edit_own({label: {} for label in blocks})

    def copy_own(self, source: int, blocks: Collection[int]) -> None:
        """Copy the own parameters of a block to others."""
        values = self._frames.current.blocks.own.get(source, {})
        self._edit_own(dict.fromkeys(blocks, values))

    def _edit_own(self, wanted: Mapping[int, OwnValues]) -> None:
        changes = self._own_changes(wanted)
        self._edit(None, changes, names_in(changes))

    def _own_changes(self, wanted: Mapping[int, OwnValues]) -> OwnChange:
        """Return the changes that give blocks these own parameters."""
        own = self._frames.current.blocks.own
        return {
            label: (own.get(label), values or None)
            for label, values in wanted.items()
            if values != (own.get(label) or {})
        }

    def _edit(
        self,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
    ) -> None:
        if not names:
            return
        if not self._frames.has_current:
            if common is not None:
                self.set_shared(SharedParameters(self.shared.on, common[1]))
            return
        document = self._frames.current
        stack = document.undo_stack
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(common, own, names):
            document.note_edit()
            self._frames.touch(document)
            return
        what = parameter_labels(names)[0] if len(names) == 1 else f"{len(names)} filter parameters"
        blocks = f" of {document.info(min(own)).name}" if len(own) == 1 else f" of {len(own)} blocks"
        where = blocks if own else self.all_frames_text(document)
        stack.push(EditParameters(self, document, common, own, names, f"Set {what}{where}"))

    def all_frames_text(self, document: Document) -> str:
        """Return the end of the text of an undo step on a frame's common parameters."""
        return " for all frames" if self.shared.applies_to(document) else ""

    def take(
        self, document: Document, common: OwnValues, own: Mapping[int, OwnValues | None], transient: bool = False
    ) -> None:
        """Set some of the common parameters and own parameters of blocks (None for none). Called by commands.

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
            self.shared.apply_to_all(self._frames.open, transient)
            self._frames.project_touched.emit()
        document.note(Part.PARAMETERS)
        if document.valid_results() != before:  # results of earlier parameters are valid again
            document.note(Part.RESULTS)

    def take_common(self, document: Document, common: Parameters, own: bool) -> None:
        """Set a frame's common parameters, unless it has the shared ones. Called by commands.

        With `own`, they are its own while parameters are shared by all frames.
        """
        document.change(common=common, own_parameters=own)
        self.shared.apply_to(document)
        document.note(Part.PARAMETERS)

    def set_shared(self, shared: SharedParameters) -> None:
        """Set whether parameters are shared by all frames, and which; also on loading a project, before its frames."""
        former, self.shared = self.shared, shared
        shared.apply_to_all(self._frames.open)
        if former.on and not shared.on:  # from now on they are stored with each frame
            for document in self._frames.open:
                if document.counts() or document.unsaved:
                    self._frames.touch(document)
        self._frames.note(Part.PARAMETERS)
        self._frames.project_touched.emit()

    def share(self) -> list[Document]:
        """Share the current frame's parameters with all frames without own ones, as one undo step.

        Returns the open frames that had other parameters.
        """
        shared = SharedParameters(True, self.current)
        states = {document: document.state for document in self._frames.open}
        others = [one for one, state in states.items() if not state.own_parameters and state.common != self.current]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return [one for one in others if one is not self._frames.current]

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
        frames, document = self._frames, self._frames.current

        def exchange(to: _Sharing) -> _Sharing:
            before = self.shared, document.state.common, document.state.own_parameters
            others = WeakKeyDictionary({one: one.state.common for one in frames.open})
            self._take_sharing(document, to)
            if to.others is not None and not self.shared.on:
                for one, common in to.others.items():
                    if one in frames.open and one.state.common != common:
                        one.remember_parameters()
                        one.change(common=common)
            for one in frames.open if before[0].on and not self.shared.on else ():
                # its parameters are now stored with it; restoring an earlier state is no unsaved change
                if one is not document and not one.state.own_parameters:
                    one.touch(viewing=to.others is not None)
            return _Sharing(*before, others if to.others is None else None)

        common = document.state.common if own or not shared.on else shared.values
        document.undo_stack.push(Swap(text, _Sharing(shared, common, own), exchange))

    def _take_sharing(self, document: Document, to: _Sharing) -> None:
        before = document.valid_results()
        document.remember_parameters()
        document.change(common=to.common, own_parameters=to.own)
        self.set_shared(to.shared)
        self._frames.note(Part.LIST)
        if document.valid_results() != before:
            document.note(Part.RESULTS)

    def restore(self, kept: StoredRun) -> bool:
        """Restore common and own parameters of a stored run in the current frame, as one undo step; False if they are
        the current ones."""
        document, run = self._frames.current, kept.run
        there = set(document.counts()).intersection(np.unique(run.blocks.labels).tolist())
        own = {label: run.parameters_of(label).differences_from(run.parameters) for label in there}
        changes = self._own_changes(own)
        names = names_in(changes).union(run.parameters.differences_from(document.state.common))
        if not names:
            return False
        common = document.state.common, run.parameters
        text = f"Restore parameters of {kept.name}{self.all_frames_text(document)}"
        document.undo_stack.push(EditParameters(self, document, common, changes, names, text))
        return True

    def set_extraction(self, parameters: BlockParameters) -> None:
        """Set the parameters of the next extraction."""
        self.extraction = parameters
        self._frames.note(Part.EXTRACTION)
        self._frames.project_touched.emit()

    def set_keeps_handmade(self, on: bool) -> None:
        """Set whether the next extraction keeps hand-made blocks."""
        self.keeps_handmade = on
        self._frames.note(Part.EXTRACTION)
        self._frames.project_touched.emit()


def names_in(changes: OwnChange) -> set[str]:
    """Return the names of the parameters that change."""
    return {name for before, after in changes.values() for name in _differing_names(before or {}, after or {})}


class EditParameters(QUndoCommand):
    """A change of the common parameters, or of own parameters of blocks.

    Parameters
    ----------
    common : (Parameters, Parameters) or None
        Before and after; None if unchanged.
    own : mapping of int to (mapping or None, mapping or None)
        Block label -> its own parameters before and after, None for none.
    names : collection of str
        The parameters that change.
    """

    def __init__(
        self,
        host: DocumentParameters,
        document: Document,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
        text: str,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._document = document
        self._common = common
        self._own = own
        self._names = frozenset(names)
        self._time = time.monotonic()

    def extend(self, common: tuple[Parameters, Parameters] | None, own: OwnChange, names: Collection[str]) -> bool:
        """Extend the step by new values of the same parameters if they follow quickly, as from a moving slider.

        False if they do not.
        """
        now = time.monotonic()
        same = (self._common is None) == (common is None) and self._own.keys() == own.keys()
        if not same or self._names != frozenset(names) or now - self._time > DRAG_S:
            return False
        if self._common is not None and common is not None:
            self._common = self._common[0], common[1]
        self._own = {label: (self._own[label][0], own[label][1]) for label in own}
        self._time = now
        self._take(1, transient=True)
        return True

    def redo(self) -> None:
        """Apply the change."""
        self._take(1)

    def undo(self) -> None:
        """Undo the change."""
        self._take(0)

    def _take(self, which: int, transient: bool = False) -> None:
        values = {} if self._common is None else self._common[which].to_dict()
        self._host.take(
            self._document,
            {name: value for name, value in values.items() if name in self._names},
            {label: values[which] for label, values in self._own.items()},
            transient,
        )


def _differing_names(one: OwnValues, other: OwnValues) -> set[str]:
    """Return the names whose values differ, or that only one of the two has."""
    return {name for name in {*one, *other} if name not in one or name not in other or one[name] != other[name]}


def parameter_labels(names: Iterable[str]) -> list[str]:
    """Return the labels of parameters, in the order in which they are declared."""
    declarations = Parameters.declarations()
    return [declarations[name].label for name in declarations if name in set(names)]

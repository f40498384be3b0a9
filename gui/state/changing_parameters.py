"""What changes the parameters of filter and extraction."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ilf.data.parameters import Parameters
from ilf.project.frame_state import OwnValues, differing, own_values, parameter_labels

from .commands import EditParameters, OwnChange
from .frames_at_work import FramesAtWork
from .session import Session
from .sharing import Shared, ShareParameters


class ChangingParameters(FramesAtWork):
    """Parameters change here: of all frames, of one, or of blocks."""

    def set_parameters(self, parameters: Parameters, blocks: int | Collection[int] | None = None) -> None:
        """Parameters of all blocks that have no values of their own, or of some blocks, as one undoable step.

        Of blocks, the values that differ from the common ones become their own. What is set while a slider is being
        moved is one step with what was set before.
        """
        if blocks is None:
            self._edit_parameters((self.parameters, parameters), {}, own_values(parameters, self.parameters).keys())
            return
        labels = [blocks] if isinstance(blocks, int) else blocks
        self._edit_own(dict.fromkeys(labels, own_values(parameters, self.parameters)))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Give blocks some values of their own, one parameter beside the other; those equal to the common ones go."""
        common, own = self.parameters.to_dict(), self.session.notes.own
        merged = {label: {**own.get(label, {}), **values} for label in blocks}
        self._edit_own(
            {
                label: {name: value for name, value in one.items() if value != common[name]}
                for label, one in merged.items()
            }
        )

    def reset_own(self, blocks: Collection[int]) -> None:
        """Take all values of their own from blocks."""
        self._edit_own({label: {} for label in blocks})

    def copy_own(self, source: int, blocks: Collection[int]) -> None:
        """Give blocks the very own values that another one has."""
        values = self.session.notes.own.get(source, {})
        self._edit_own(dict.fromkeys(blocks, values))

    def _edit_own(self, wanted: Mapping[int, OwnValues]) -> None:
        changes = self._own_changes(wanted)
        self._edit_parameters(None, changes, names_in(changes))

    def _own_changes(self, wanted: Mapping[int, OwnValues]) -> OwnChange:
        """What changes if blocks are to have these own values."""
        own = self.session.notes.own
        return {
            label: (own.get(label), values or None)
            for label, values in wanted.items()
            if values != (own.get(label) or {})
        }

    def _edit_parameters(
        self,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
    ) -> None:
        if not names:
            return
        if self._session is None:
            if common is not None:
                self.set_shared(Shared(self.shared.on, common[1]))
            return
        stack = self._session.undo_stack
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(common, own, names):
            self._session.note_edit()
            self.touched.emit(self._session)
            return
        what = parameter_labels(names)[0] if len(names) == 1 else f"{len(names)} values of the filter"
        blocks = f" of {self._session.info(min(own)).name}" if len(own) == 1 else f" of {len(own)} blocks"
        where = blocks if own else self._for_all(self._session)
        stack.push(EditParameters(self, self._session, common, own, names, f"Set {what}{where}"))

    def _for_all(self, session: Session) -> str:
        """What the text of a step on a frame's common parameters ends with."""
        return " for all frames" if self.shared.reach(session) else ""

    def take_parameters(
        self, session: Session, common: OwnValues, own: Mapping[int, OwnValues | None], passing: bool = False
    ) -> None:
        """Called by commands: other values of some of the common parameters, and other own values of blocks, None for
        none; with `passing`, no undo leads back to the present ones."""
        before = session.valid_results()
        if not passing:
            session.settle_parameters()
        for label, values in own.items():
            if values:
                session.notes.own[label] = values
            else:
                session.notes.own.pop(label, None)
        session.take_common(session.common.replace(**common))
        if common and self.shared.reach(session):
            self.shared = Shared(True, session.common)
            self.shared.spread(self.sessions, passing)
            self.project_touched.emit()
        if session is self._session:
            self.parameters_changed.emit()
        if session.valid_results() != before:  # those of the values that have come back
            self.note_results_changed(session)

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Called by commands: other common parameters of a frame, unless it has those of all; `own`: its own where
        parameters are for all frames."""
        session.own_parameters = own
        session.take_common(common)
        self.shared.begin(session)
        if session is self._session:
            self.parameters_changed.emit()

    def set_shared(self, shared: Shared) -> None:
        """Whether parameters are for all frames, and which: as a project has it, before its frames are opened."""
        former, self.shared = self.shared, shared
        shared.spread(self.sessions)
        if former.on and not shared.on:  # from now on they are what is stored of each frame
            for session in self.sessions:
                if session.counts() or session.unsaved:
                    self.touched.emit(session)
        self.parameters_changed.emit()
        self.project_touched.emit()

    def share_parameters(self) -> list[Session]:
        """Have the present frame's parameters in all frames without their own, now and from now on, as one undoable
        step; the open ones that had others."""
        shared = Shared(True, self.parameters)
        others = [one for one in self.sessions if not one.own_parameters and one.common != self.parameters]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return [one for one in others if one is not self._session]

    def keep_own_parameters(self) -> None:
        """Let the present frame's parameters be its own where they are for all frames, as one undoable step."""
        self._push_sharing(self.shared, own=True, text="Parameters for this frame alone")

    def reset_to_shared(self) -> None:
        """Let the present frame have the parameters of all frames again, as one undoable step."""
        self._push_sharing(self.shared, own=False, text="Reset to the parameters of all frames")

    def part_parameters(self) -> None:
        """Let every frame have its own parameters again, which are what they are, as one undoable step."""
        self._push_sharing(Shared(False, self.parameters), own=False, text="Parameters of each frame by itself")

    def _push_sharing(self, shared: Shared, own: bool, text: str) -> None:
        self.session.undo_stack.push(ShareParameters(self, self.session, shared, own, text))

    def take_shared(self, shared: Shared, session: Session, common: Parameters, own: bool) -> None:
        """Called by commands: whether parameters are for all frames, which those are, and those of one frame."""
        before = session.valid_results()
        session.settle_parameters()
        session.own_parameters = own
        session.take_common(common)
        self.set_shared(shared)
        self.sessions_changed.emit()
        if session.valid_results() != before:
            self.note_results_changed(session)

    def set_keeps_handmade(self, on: bool) -> None:
        """Whether blocks made by hand stay at the next extraction."""
        self.keeps_handmade = on
        self.extraction_changed.emit()
        self.project_touched.emit()


def names_in(changes: OwnChange) -> set[str]:
    """The parameters whose own values change."""
    return {name for before, after in changes.values() for name in differing(before or {}, after or {})}

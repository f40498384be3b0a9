"""Changes of the filter and extraction parameters."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ilf.data.parameters import Parameters
from ilf.project.frame_state import OwnValues, differing_names, own_values, parameter_labels

from .commands import EditParameters, OwnChange
from .session import Session
from .sharing import SharedParameters, ShareParameters
from .workspace_frames import WorkspaceFrames


class WorkspaceParameters(WorkspaceFrames):
    """The part of the workspace that changes parameters: of all frames, of one frame, or of blocks."""

    def set_parameters(self, parameters: Parameters, blocks: int | Collection[int] | None = None) -> None:
        """Set the common parameters, or those of some blocks, as one undo step.

        For blocks, the values that differ from the common ones become own parameters. Values set while a slider moves
        belong to the same step.
        """
        if blocks is None:
            self._edit_parameters((self.parameters, parameters), {}, own_values(parameters, self.parameters).keys())
            return
        labels = [blocks] if isinstance(blocks, int) else blocks
        self._edit_own(dict.fromkeys(labels, own_values(parameters, self.parameters)))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Add own parameters to blocks; values equal to the common ones are removed."""
        common, own = self.parameters.to_dict(), self.session.notes.own
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
        values = self.session.notes.own.get(source, {})
        self._edit_own(dict.fromkeys(blocks, values))

    def _edit_own(self, wanted: Mapping[int, OwnValues]) -> None:
        changes = self._own_changes(wanted)
        self._edit_parameters(None, changes, names_in(changes))

    def _own_changes(self, wanted: Mapping[int, OwnValues]) -> OwnChange:
        """Return the changes that give blocks these own parameters."""
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
                self.set_shared(SharedParameters(self.shared.on, common[1]))
            return
        stack = self._session.undo_stack
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(common, own, names):
            self._session.note_edit()
            self.touched.emit(self._session)
            return
        what = parameter_labels(names)[0] if len(names) == 1 else f"{len(names)} filter parameters"
        blocks = f" of {self._session.info(min(own)).name}" if len(own) == 1 else f" of {len(own)} blocks"
        where = blocks if own else self._for_all(self._session)
        stack.push(EditParameters(self, self._session, common, own, names, f"Set {what}{where}"))

    def _for_all(self, session: Session) -> str:
        """Return the end of the text of an undo step on a frame's common parameters."""
        return " for all frames" if self.shared.applies_to(session) else ""

    def take_parameters(
        self, session: Session, common: OwnValues, own: Mapping[int, OwnValues | None], transient: bool = False
    ) -> None:
        """Set some of the common parameters and own parameters of blocks (None for none). Called by commands.

        With `transient`, undo does not lead back to the present ones.
        """
        before = session.valid_results()
        if not transient:
            session.remember_parameters()
        for label, values in own.items():
            if values:
                session.notes.own[label] = values
            else:
                session.notes.own.pop(label, None)
        session.take_common(session.common.replace(**common))
        if common and self.shared.applies_to(session):
            self.shared = SharedParameters(True, session.common)
            self.shared.apply_to_all(self.sessions, transient)
            self.project_touched.emit()
        if session is self._session:
            self.parameters_changed.emit()
        if session.valid_results() != before:  # results of earlier parameters are valid again
            self.note_results_changed(session)

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Set a frame's common parameters, unless it has the shared ones. Called by commands.

        With `own`, they are its own while parameters are shared by all frames.
        """
        session.own_parameters = own
        session.take_common(common)
        self.shared.apply_to(session)
        if session is self._session:
            self.parameters_changed.emit()

    def set_shared(self, shared: SharedParameters) -> None:
        """Set whether parameters are shared by all frames, and which; also on loading a project, before its frames."""
        former, self.shared = self.shared, shared
        shared.apply_to_all(self.sessions)
        if former.on and not shared.on:  # from now on they are stored with each frame
            for session in self.sessions:
                if session.counts() or session.unsaved:
                    self.touched.emit(session)
        self.parameters_changed.emit()
        self.project_touched.emit()

    def share_parameters(self) -> list[Session]:
        """Share the current frame's parameters with all frames without own ones, as one undo step.

        Returns the open frames that had other parameters.
        """
        shared = SharedParameters(True, self.parameters)
        others = [one for one in self.sessions if not one.own_parameters and one.common != self.parameters]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return [one for one in others if one is not self._session]

    def keep_own_parameters(self) -> None:
        """Give the current frame its own parameters while others are shared, as one undo step."""
        self._push_sharing(self.shared, own=True, text="Use parameters for this frame only")

    def reset_to_shared(self) -> None:
        """Reset the current frame to the shared parameters, as one undo step."""
        self._push_sharing(self.shared, own=False, text="Reset to shared parameters")

    def separate_parameters(self) -> None:
        """Stop sharing parameters: every frame keeps its current ones as its own, as one undo step."""
        self._push_sharing(
            SharedParameters(False, self.parameters), own=False, text="Separate parameters for each frame"
        )

    def _push_sharing(self, shared: SharedParameters, own: bool, text: str) -> None:
        self.session.undo_stack.push(ShareParameters(self, self.session, shared, own, text))

    def take_shared(self, shared: SharedParameters, session: Session, common: Parameters, own: bool) -> None:
        """Set whether parameters are shared, the shared ones, and those of one frame. Called by commands."""
        before = session.valid_results()
        session.remember_parameters()
        session.own_parameters = own
        session.take_common(common)
        self.set_shared(shared)
        self.sessions_changed.emit()
        if session.valid_results() != before:
            self.note_results_changed(session)

    def set_keeps_handmade(self, on: bool) -> None:
        """Set whether the next extraction keeps hand-made blocks."""
        self.keeps_handmade = on
        self.extraction_changed.emit()
        self.project_touched.emit()


def names_in(changes: OwnChange) -> set[str]:
    """Return the names of the parameters that change."""
    return {name for before, after in changes.values() for name in differing_names(before or {}, after or {})}

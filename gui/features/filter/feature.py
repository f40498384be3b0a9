"""Shows the parameters of the filter in their panel, and applies changes to the workspace and the selected blocks."""

from __future__ import annotations

from collections.abc import Sequence

from ilf.data.blocks import OwnValues, own_values
from ilf.data.parameters import Parameters

from ...base.commands import Command
from ...base.needs import Need
from ...state.document import Document
from ...state.parameters import parameter_labels
from ...state.parts import Part
from ..context import Context, Feature
from .panel import FilterPanel, Sharing
from .sharing import SharingCommands


class FilterFeature(Feature):
    """The parameters of all blocks, or of the selected ones, which are completed again on changes; and which frames
    share them."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = workspace = context.workspace
        self._runs = context.runs
        actions = context.actions
        self._live = actions["live"]
        self.sharing = SharingCommands(workspace)
        self.sharing.message.connect(context.notes.show_message)
        actions.add(self._commands())
        self.panel = FilterPanel(
            [actions[name] for name in ("copy_own", "reset_own")],
            [actions[name] for name in ("share_parameters", "reset_to_shared")],
        )
        self.panel.edited.connect(self.take)
        self.panel.preset_chosen.connect(self.take_preset)
        self.panel.frames.chosen.connect(self.sharing.choose)
        turned, values = workspace.frames.session_changed, workspace.parameters.changed
        chosen = workspace.blocks.infos_changed, workspace.blocks.selection_changed
        context.refresh.add("filter", self.show, (turned, *chosen, values, self.panel.scope_changed))
        context.refresh.add("sharing", self.show_sharing, on=Part.FRAME | Part.PARAMETERS | Part.LIST)

    def _commands(self) -> Sequence[Command]:
        sharing = self.sharing

        return (
            Command(
                "reset_own",
                "Reset &own parameters",
                "Reset the selected blocks to the common parameters",
                icon="ph.eraser",
                handler=self.reset_own,
                needs=Need.SELECTION,
                why_off=self._why_none_own,
            ),
            Command(
                "copy_own",
                "Copy own para&meters",
                "Copy the own parameters of the first selected block to the other selected blocks",
                icon="ph.copy",
                handler=self.copy_own,
                why_off=self._why_no_copy,
            ),
            Command(
                "share_parameters",
                "Use parameters for all &frames",
                "Use this frame's filter parameters for all frames in the list, now and after each change",
                icon="ph.share-network",
                handler=sharing.share,
                needs=Need.FRAME,
                why_off=lambda: (
                    "The parameters are shared by all frames already." if sharing.present is Sharing.ALL else ""
                ),
            ),
            Command(
                "keep_own_parameters",
                "Use parameters for this frame o&nly",
                "Give this frame its own filter parameters: changes for all frames do not affect them",
                icon="ph.push-pin",
                handler=sharing.keep,
                needs=Need.FRAME,
                why_off=lambda: (
                    self._why_not_shared()
                    or ("" if sharing.present is Sharing.ALL else "This frame has its own parameters already.")
                ),
            ),
            Command(
                "reset_to_shared",
                "Reset to s&hared parameters",
                "Reset this frame to the filter parameters that all frames share",
                icon="ph.arrow-u-up-left",
                handler=sharing.reset,
                needs=Need.FRAME,
                why_off=lambda: (
                    self._why_not_shared()
                    or ("" if sharing.present is Sharing.ALONE else "This frame uses the shared parameters already.")
                ),
            ),
            Command(
                "separate_parameters",
                "Separa&te parameters for each frame",
                "Set filter parameters for each frame separately; all frames keep their current parameters",
                handler=sharing.separate,
                needs=Need.FRAME,
                why_off=self._why_not_shared,
            ),
        )

    def _why_not_shared(self) -> str:
        return "Every frame has its own parameters." if self.sharing.present is Sharing.EACH else ""

    def _why_none_own(self) -> str:
        document = self._workspace.current
        own = document.blocks.own.keys() & document.selected & document.counts().keys()
        return "" if own else "The selected blocks have no parameters of their own."

    def _why_no_copy(self) -> str:
        document = self._workspace.current if self._workspace.has_current else None
        if document is not None and len(document.selected) > 1 and document.selected[0] in document.blocks.own:
            return ""
        return "Select a block with parameters of its own first, then other blocks."

    @property
    def shown(self) -> Parameters:
        """The parameters that the panel shows: those of all blocks, or of the first selected one."""
        common = self._workspace.parameters.current
        return self._workspace.current.parameters_of(self._workspace.chosen) if self._for_selected else common

    def show(self) -> None:
        """Show the parameters of all blocks, or of the first selected one."""
        workspace = self._workspace
        chosen = workspace.current.selected if workspace.has_current else []
        names = [workspace.current.info(label).name for label in chosen]
        alone = workspace.parameters.shared.on and workspace.has_current and workspace.current.state.own_parameters
        of_all = workspace.parameters.shared.values if alone else None
        self.panel.show_parameters(self.shown, workspace.parameters.current, names, of_all)

    def show_sharing(self) -> None:
        """Show which frames share the parameters."""
        self.panel.frames.show_sharing(self.sharing.present)
        self.panel.frames.setEnabled(self._workspace.has_current)
        self.panel.show_frames(len(self._workspace.entries) > 1)

    def take(self, parameters: Parameters) -> None:
        """Apply edited parameters to all blocks or to the selected ones, and complete these again if that is on."""
        if self._for_selected:
            self._workspace.parameters.set_own(own_values(parameters, self.shown), self._workspace.current.selected)
        else:
            self._workspace.parameters.set(parameters)
        self._resolve()

    def set_values(self, values: OwnValues, label: int = 0) -> None:
        """Apply some parameters to all blocks or to one (selected or not), as if they were edited in the form."""
        workspace = self._workspace
        if label:
            workspace.parameters.set_own(values, [label])
            if self._live.isChecked():
                self._runs.resolve([label])
        else:
            workspace.parameters.set(workspace.parameters.current.replace(**values))
            self._resolve()

    def take_preset(self, parameters: Parameters) -> None:
        """Apply all parameters of a preset; per-block parameters stay, which a message reports."""
        if self._for_selected:
            self._workspace.parameters.set(parameters, self._workspace.current.selected)
        else:
            self._workspace.parameters.set(parameters)
            left = _describe_own(self._workspace.current) if self._workspace.has_current else ""
            if left:
                self.context.notes.show_message(f"Per-block parameters are kept: {left}.")
        self._resolve()

    def reset_own(self) -> None:
        """Remove the per-block parameters of the selected blocks."""
        self._workspace.parameters.reset_own(self._workspace.current.selected)
        self._resolve()

    def copy_own(self) -> None:
        """Copy the per-block parameters of the first selected block to the others."""
        first, *others = self._workspace.current.selected
        self._workspace.parameters.copy_own(first, others)
        self._resolve()

    @property
    def _for_selected(self) -> bool:
        return bool(self._workspace.chosen) and self.panel.for_selected

    def _resolve(self) -> None:
        if self._workspace.chosen and self._live.isChecked():
            there = self._workspace.current.counts()
            wanted = [label for label in self._workspace.current.selected if label in there]
            if wanted:
                self._runs.resolve(wanted)


def _describe_own(document: Document) -> str:
    """Describe which blocks have which per-block parameters."""
    there = document.counts()
    return "; ".join(
        f"{document.info(label).name} ({', '.join(parameter_labels(values))})"
        for label, values in sorted(document.blocks.own.items())
        if label in there
    )

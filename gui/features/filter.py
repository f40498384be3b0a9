"""The panel of the filter: its parameters for all blocks or the selected ones, and what a change did to the depth."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from ilf.data.blocks import OwnValues
from ilf.data.parameters import DEFAULT_PRESET, Parameters
from ilf.data.results import BlockResult

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parameters import parameter_labels
from ..state.parts import Part
from ..widgets.basics import TEXT, Late, PlainLabel, combo, command_button, form, lay_out
from ..widgets.parameter_form import ParameterForm
from .context import Context
from .panel import Panel
from .parameter_effects import Effect, Tried, effect_of, try_parameters
from .presets import PresetBox
from .runs import RunsFeature
from .sharing import SharingPanel

_SHOWN = Part.FRAME | Part.LIST | Part.INFOS | Part.SELECTION | Part.PARAMETERS
_OTHER_DEPTH = Part.FRAME | Part.LABELS | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS | Part.BY_HAND
"""What changes depth other than parameters."""


class _Change(NamedTuple):
    """A change of one parameter by the user, as long as it is one undo step, and the results before it."""

    name: str
    document: Document
    step: int
    before: Mapping[int, BlockResult]


class FilterPanel(Panel):
    """The parameters of all blocks, or of the selected ones, which are completed again on changes.

    Beside a parameter it shows how much its last change has changed the depth. On request it tries other values of the
    parameters that it shows, and puts those first that change this frame most.
    """

    title, icon, group, at_start = "Filter", "ph.sliders-horizontal", None, True
    parts = _SHOWN | Part.RESULTS | _OTHER_DEPTH
    what = "trial of parameters"

    def __init__(self, context: Context) -> None:
        self._bases = {False: DEFAULT_PRESET, True: DEFAULT_PRESET}
        """The preset that parameters are based on, by `for_selected`."""
        self._effects: dict[str, str] = {}
        self._change: _Change | None = None
        self._edited: Parameters | None = None
        """The parameters after the user's last change."""
        super().__init__(context)

    def make(self) -> QWidget:
        """Make the rows of preset, blocks and frames, and the form."""
        actions = self.context.actions
        self.presets = PresetBox(self.context, lambda: self.shown)
        self.presets.chosen.connect(self._choose_preset)
        self.presets.changed.connect(self._take_presets)
        hint = "Whether the parameters below apply to all blocks, or to the selected ones only"
        self.scope = combo(["All blocks", "Selected blocks"], hint, "Parameters for")
        self.scope.activated.connect(self.redraw)
        self._all = PlainLabel("All blocks")  # as high, so that the form stays where it is when a block is selected
        self._all.setMinimumHeight(self.scope.sizeHint().height())
        self.form = ParameterForm(Parameters)
        self.form.changed.connect(self.edit)
        self._own_buttons = [command_button(actions[name]) for name in ("copy_own", "reset_own")]
        # with an icon it is cut off in a small window
        self.form.footer.insertWidget(1, command_button(actions["try_parameters"], TEXT))

        texts = self._all, self.scope
        scope = lay_out(QHBoxLayout(), *texts, *self._own_buttons, spacing=2, stretched=texts)
        for button in self._own_buttons:
            button.hide()  # a panel is as wide as it is at first
        self._frames = Late(lambda: self.context.feature(SharingPanel).widget)
        self._choices = form(("Parameters for", scope), ("Preset", self.presets), ("Frames", self._frames))
        self._choices.setRowVisible(self._frames, False)
        widget = QWidget()
        lay_out(QVBoxLayout(widget), self._choices, self.form, self.work, margins=(8, 8, 4, 4), stretched=self.form)
        return widget

    # what is shown

    @property
    def for_selected(self) -> bool:
        """Whether the parameters are those of the selected blocks."""
        return bool(self.workspace.chosen) and self.scope.currentIndex() == 1

    @property
    def shown(self) -> Parameters:
        """The parameters that the panel shows: those of all blocks, or of the first selected one."""
        if self.for_selected:
            return self.workspace.current.parameters_of(self.workspace.chosen)
        return self.workspace.parameters.current

    @property
    def _selected(self) -> set[int]:
        """The selected blocks that have pixels."""
        document = self.workspace.current
        return set(document.selected) & document.counts().keys()

    def refresh(self, parts: Part) -> None:
        """Show the parameters, and what the last change of one of them has changed."""
        if parts & _SHOWN or not parts & self.parts:
            self._show_parameters()
        if parts & _OTHER_DEPTH or (self._effects and self.shown != self._edited):
            self._forget_effects()
        if parts & Part.RESULTS and self._change is not None:
            self._compare(self._change)

    def _show_parameters(self) -> None:
        """Show parameters: those of the selected blocks relative to the common ones, a frame's own ones relative to
        those of all frames, others relative to their preset."""
        chosen = self.workspace.shown.selected if self.workspace.shown is not None else ()
        text = "Selected blocks" if not chosen else f"{len(chosen)} selected blocks"
        self.scope.setItemText(1, f"{self.workspace.current.info(chosen[0]).name} only" if len(chosen) == 1 else text)
        if not chosen:
            self.scope.setCurrentIndex(0)
        self.scope.setVisible(bool(chosen))
        self._all.setVisible(not chosen)
        scope, parameters = self.for_selected, self.shown
        for button in self._own_buttons:
            button.setVisible(scope)
        self._choices.setRowVisible(self._frames, len(self.workspace.entries) > 1)
        self._bases[scope] = self.presets.show_parameters(parameters, self._bases[scope])
        shared = self.workspace.parameters.shared
        if scope:
            base, source = self.workspace.parameters.current, "all blocks"
        elif shared.on and self.workspace.shown is not None and self.workspace.shown.state.own_parameters:
            base, source = shared.values, "all frames"
        else:
            base, source = self.presets.parameters(self._bases[scope]), "the preset"
        self.form.set_parameters(parameters, base, source)

    # changes

    def edit(self, parameters: Parameters) -> None:
        """Apply edited parameters to all blocks or to the selected ones, and complete these again if that is on."""
        names = parameters.differences_from(self.shown)
        before = _up_to_date(self.workspace.shown) if self.workspace.shown is not None else {}
        if self.for_selected:
            self.workspace.parameters.set_own(names, self.workspace.current.selected)
        else:
            self.workspace.parameters.set(parameters)
        self._edited = parameters
        if self.workspace.shown is not None and len(names) == 1:
            self._note_change(next(iter(names)), before)
        self._resolve()

    def _note_change(self, name: str, before: Mapping[int, BlockResult]) -> None:
        """Note the results before a change; while a slider moves, they are those before it began to."""
        document = self.workspace.current
        step = document.undo_stack.index()
        former = self._change
        if former is None or (former.name, former.document, former.step) != (name, document, step):
            self._change = _Change(name, document, step, before)
            self._effects.pop(name, None)

    def set_values(self, values: OwnValues, label: int = 0) -> None:
        """Apply some parameters to all blocks or to one (selected or not), as if they were edited in the form."""
        if label:
            self.workspace.parameters.set_own(values, [label])
            self.context.feature(RunsFeature).live.follow_parameters([label])
        else:
            self.workspace.parameters.set(self.workspace.parameters.current.replace(**values))
            self._resolve()

    def _choose_preset(self, name: str) -> None:
        """Apply all parameters of a preset; per-block parameters stay, which a message reports."""
        self._bases[self.for_selected] = name
        workspace, parameters = self.workspace, self.presets.parameters(name)
        if self.for_selected:
            workspace.parameters.set(parameters, workspace.current.selected)
        else:
            workspace.parameters.set(parameters)
            left = _describe_own(workspace.shown) if workspace.shown is not None else ""
            if left:
                self.notes.show_message(f"Per-block parameters are kept: {left}.")
        self._resolve()
        self.redraw()

    def _take_presets(self, name: str) -> None:
        """Show the user's presets anew; the parameters are based on the one with this name, unless it is ""."""
        if name:
            self._bases[self.for_selected] = name
        self.redraw()

    def _why_none_own(self) -> str:
        own = self.workspace.current.blocks.own
        return "" if not self._selected.isdisjoint(own) else "The selected blocks have no parameters of their own."

    @command("reset_own", "Reset &own parameters", icon="ph.eraser", needs=Need.SELECTION, why_off=_why_none_own)
    def reset_own(self) -> None:
        """Reset the selected blocks to the common parameters."""
        self.workspace.parameters.reset_own(self.workspace.current.selected)
        self._resolve()

    def _why_no_copy(self) -> str:
        document = self.workspace.current
        if len(document.selected) > 1 and document.selected[0] in document.blocks.own:
            return ""
        return "Select a block with parameters of its own first, then other blocks."

    @command("copy_own", "Copy own parameters", icon="ph.copy", needs=Need.SELECTION, why_off=_why_no_copy)
    def copy_own(self) -> None:
        """Copy the own parameters of the first selected block to the other selected blocks."""
        first, *others = self.workspace.current.selected
        self.workspace.parameters.copy_own(first, others)
        self._resolve()

    def _resolve(self) -> None:
        """Complete again what the parameters have changed, the selected blocks first, if that is on."""
        if self.workspace.shown is not None:
            self.context.feature(RunsFeature).live.follow_parameters(self.workspace.shown.selected)

    # what changes did

    @command("try_parameters", "Tr&y parameters", icon="ph.sort-descending", needs=Need.BLOCKS | Need.IDLE)
    def try_shown(self) -> None:
        """Try smaller and larger values of the parameters shown, and put those first that change the depth of this
        frame most; its parameters and results stay as they are."""
        blocks = sorted(self._selected) if self.for_selected else ()
        self._change, self._edited = None, self.shown
        run, names = self.workspace.current.run(self.workspace.parameters.current), self.form.shown
        self.requests.ask(lambda: try_parameters(run, names, blocks), self._show_trial, kind="trial")

    def _compare(self, change: _Change) -> None:
        """Compare the results of the blocks that have been completed again with those before the change."""
        now = _up_to_date(change.document)
        same = change.before.keys() & now.keys()
        depths = [(change.before[label].depth, now[label].depth) for label in sorted(same)]
        if depths:
            self.requests.ask(lambda: effect_of(depths), partial(self._show_effect, change), kind="effect")

    def _show_effect(self, change: _Change, effect: Effect) -> None:
        if change is self._change:
            self._effects[change.name] = effect.text
            self.form.show_effects(self._effects)

    def _show_trial(self, found: dict[str, Tried]) -> None:
        """Show the effects beside the parameters, those with the largest effect first."""
        declarations = Parameters.declarations()
        self._effects = {
            name: f"at {declarations[name].to_text(value)}: {effect.text}" for name, (value, effect) in found.items()
        }
        acting = [name for name, (_, effect) in found.items() if effect.pixels]
        self.form.put_first(sorted(acting, key=lambda name: -found[name][1].size))
        self.form.show_effects(self._effects)

    def _forget_effects(self) -> None:
        """Show no effects: they were of another frame, other blocks or other parameters."""
        self.requests.cancel()
        self._change = None
        if self._effects:
            self._effects = {}
            self.form.show_effects({})
            self.form.put_first(())


def _up_to_date(document: Document) -> dict[int, BlockResult]:
    """Return the results of the blocks that have one of their current parameters."""
    results = document.valid_results()
    return {label: results[label] for label in results if document.is_up_to_date(label)}


def _describe_own(document: Document) -> str:
    """Describe which blocks have which per-block parameters."""
    there = document.counts()
    return "; ".join(
        f"{document.info(label).name} ({', '.join(parameter_labels(values))})"
        for label, values in sorted(document.blocks.own.items())
        if label in there
    )

"""The user's presets: saved, renamed, deleted, imported and exported."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QInputDialog,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from ilf.data import presets
from ilf.data.parameters import DEFAULT_PRESET, PRESETS, Parameters, nearest_preset
from ilf.errors import IlfError

from ..base import theme
from ..base.commands import command, commands_of
from ..widgets.basics import answers, label_of, lay_out, menu_button, open_once
from ..widgets.file_choice import ask_path, choose_file, last_folder, remember_folder
from ..widgets.notices import DESTROY, ask
from ..work.steps import Steps, in_steps
from .context import Context

# The dialog that saves parameters as a preset of the user.


class SavePresetDialog(QDialog):
    """Dialog for the name of a preset, and whether it includes the parameters of the extraction."""

    def __init__(self, proposed: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save preset")
        self.name = QLineEdit(proposed)
        self.name.setToolTip("Name of the preset in the list of presets and for --preset")
        self.name.selectAll()
        self.with_extraction = QCheckBox("Include the parameters of the tab &Extraction")
        self.with_extraction.setToolTip("The preset then also sets the parameters of the extraction")
        label = label_of("&Name", self.name)
        buttons, self.save_button = answers(self, QDialogButtonBox.StandardButton.Save)
        self.name.textChanged.connect(self._allow)
        lay_out(QVBoxLayout(self), label, self.name, self.with_extraction, buttons, margins=(14, 14, 14, 14), spacing=8)
        self.setMinimumWidth(340)
        self._allow()

    def _allow(self) -> None:
        self.save_button.setEnabled(bool(self.name.text().strip()))


_FOLDER_KEY = "presets/folder"
_FILES = "Preset (*.json)"


_ABOUT = "best: adapts to edges and noise. paper: as described in the paper. released-code: as in the authors' program."


class PresetBox(QWidget):
    """List that shows the preset of some parameters, or the preset they are based on, and selects another; with the
    commands on the user's presets in a menu.

    Parameters
    ----------
    shown : callable
        Returns the parameters of the filter, which are saved.

    Signals
    -------
    chosen(str)
        Name of the preset that the user has selected.
    changed(str)
        The user's presets have changed; the name of the one that the parameters are based on now, or "".
    """

    chosen = Signal(str)
    changed = Signal(str)

    def __init__(self, context: Context, shown: Callable[[], Parameters]) -> None:
        super().__init__()
        self._context = context
        self._shown = shown
        self._own: dict[str, presets.UserPreset] = {}
        self.names = QComboBox()
        self.names.setAccessibleName("Preset")
        self.names.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.names.activated.connect(lambda _: self._choose(self.present))
        self.names.currentIndexChanged.connect(lambda _: context.actions.refresh())
        commands = list(commands_of(PresetBox, lambda: self))
        context.actions.add(commands)
        menu = context.actions.menu("", self, " ".join(command.name for command in commands))
        more = menu_button(menu, "", "Save, rename, delete, import or export presets of your own")
        more.setIcon(theme.icon("ph.dots-three-vertical"))
        lay_out(QHBoxLayout(self), self.names, more, spacing=2, stretched=self.names)
        self.read()

    @property
    def present(self) -> str:
        """Name of the preset that shows."""
        return str(self.names.currentData())

    @property
    def _all(self) -> dict[str, Parameters]:
        return {**{name: preset.parameters for name, preset in self._own.items()}, **PRESETS}

    def parameters(self, name: str) -> Parameters:
        """The values of a preset, built in or one's own; of the default preset if there is none of that name."""
        return self._all.get(name, PRESETS[DEFAULT_PRESET])

    def show_parameters(self, parameters: Parameters, base: str) -> str:
        """Show the preset of these parameters, or else `base` as changed; return the name of the preset."""
        known = self._all
        base = base if base in known else nearest_preset(parameters, known).preset
        # of presets with the same values, the selected one
        same = [name for name, values in known.items() if values == parameters]
        shown = base if base in same or not same else same[0]
        for name in known:
            text = f"{name} (changed)" if name == shown and not same else name
            self.names.setItemText(self.names.findData(name), text)
        self.names.setCurrentIndex(self.names.findData(shown))
        return shown

    def read(self) -> None:
        """Read all presets of the user, and list them below the built-in ones."""
        self._own, problems = presets.list_presets()
        present = self.names.currentData()
        with QSignalBlocker(self.names):
            self.names.clear()
            for name in PRESETS:
                self.names.addItem(name, name)
            if self._own:
                self.names.insertSeparator(len(PRESETS))
            for name in self._own:
                self.names.addItem(name, name)
            self.names.setCurrentIndex(max(self.names.findData(present), 0))
        self.names.setToolTip(_ABOUT + (" Below the line: your own presets." if self._own else ""))
        for problem in problems:
            self._context.notes.show_message(problem)

    @command("save_preset", "&Save preset as…", icon="ph.floppy-disk")
    def ask_save(self) -> None:
        """Save the parameters of the filter as a preset of your own."""
        present = self.present
        dialog = SavePresetDialog(present if present in self._own else "", self._context.window)

        def take() -> None:
            name = dialog.name.text().strip().removesuffix(presets.PRESET_SUFFIX)
            with_extraction = dialog.with_extraction.isChecked()
            extraction = self._context.workspace.parameters.extraction if with_extraction else None
            save = partial(presets.save_preset, name, self._shown(), extraction, replace=name in self._own)
            self._change("Save preset", save, f"Preset {name} saved.", name, replaces=name)

        open_once(dialog, take)

    def _why_not_own(self) -> str:
        return "" if self.present in self._own else "Select a preset of your own first."

    @command("rename_preset", "&Rename preset…", icon="ph.pencil-simple", why_off=_why_not_own)
    def ask_rename(self) -> None:
        """Rename the selected preset of your own."""
        old = self.present
        name, decided = QInputDialog.getText(self._context.window, "Rename preset", f"New name for {old}", text=old)
        new = name.strip()
        if decided and new not in ("", old):
            rename = partial(presets.rename_preset, old, new)
            self._change("Rename preset", rename, f"Preset {old} renamed to {new}.", new)

    @command("delete_preset", "&Delete preset…", icon="ph.trash", why_off=_why_not_own)
    @in_steps
    def ask_delete(self) -> Steps[None]:
        """Delete the selected preset of your own; parameters that were set from it stay."""
        name = self.present
        text, more = f"Delete the preset {name}?", "Its file is deleted, too. This cannot be undone."
        if (yield partial(ask, self._context.window, "Delete preset", text, more, [("&Delete", DESTROY)])):
            self._change("Delete preset", partial(presets.delete_preset, name), f"Preset {name} deleted.")

    @command("import_preset", "&Import preset…", icon="ph.download-simple")
    def ask_import(self) -> None:
        """Add a preset from a file to your own presets."""
        path = choose_file(self._context.window, "Import preset", _FOLDER_KEY, _FILES)
        if not path:
            return
        try:
            found = presets.read_preset(path)
        except IlfError as error:
            self._context.notes.report("Import preset", error)
            return
        name = found.name
        take = partial(presets.save_preset, name, found.parameters, found.extraction, replace=name in self._own)
        done = f"{name} imported: select it in the list of presets."
        self._change("Import preset", take, done, replaces=name)

    @command("export_preset", "&Export preset…", icon="ph.upload-simple")
    def ask_export(self) -> None:
        """Write the parameters of the filter to a file, for another computer or for 'ilf complete --preset FILE'."""
        proposed = str(Path(last_folder(_FOLDER_KEY)) / f"{self.present}.json")
        if path := ask_path(self._context.window, "Export preset", proposed, _FILES):
            remember_folder(_FOLDER_KEY, path)
            write = partial(presets.save_preset, Path(path), self._shown(), replace=True)
            self._change("Export preset", write, f"Preset written to {path}.")

    def _choose(self, name: str) -> None:
        """Pass a choice on, and apply the preset's parameters of the extraction."""
        self.chosen.emit(name)
        preset = self._own.get(name)
        if preset is not None and preset.extraction is not None:
            self._context.workspace.parameters.set_extraction(preset.extraction)
            self._context.notes.show_message(
                f"{name} also sets the parameters of the extraction: extract blocks to use them."
            )

    @in_steps
    def _change(
        self, what: str, change: Callable[[], object], text: str, chosen: str = "", replaces: str = ""
    ) -> Steps[None]:
        """Change the user's presets, and say so, or why that failed; ask first if one is replaced."""
        if replaces in self._own:
            question = f"A preset {replaces} exists already. Replace it?"
            answers = [("&Replace", DESTROY)]
            if not (yield partial(ask, self._context.window, what, question, "This cannot be undone.", answers)):
                return
        try:
            change()
        except IlfError as error:
            self._context.notes.report(what, error)
            return
        self.read()
        self.changed.emit(chosen)
        self._context.actions.refresh()
        self._context.notes.show_message(text)

"""The files of an export, with their formats and units."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QHBoxLayout, QVBoxLayout, QWidget

from ilf.data.declarations import Declaration
from ilf.data.frame import FrameInputs
from ilf.data.results import Completion
from ilf.errors import ParameterError, told_as
from ilf.io.depth import png_losses, precision_loss
from ilf.run.formats import FORMATS
from ilf.run.options import DEPTH, SPACE, ExportOptions
from ilf.run.run import Run
from ilf.run.writing import filenames

from ...widgets.basics import Message, add_layout, combo, form, group, label_of, lay_out, literal_text, typed_list

_OPTIONS_KEY = "export/files"
"""Settings key of the last choice; without PNG units, if they were the input's."""

_PNG_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "256 (KITTI)")
_NO_INTRINSICS = "The frame has no camera intrinsics. Open it again with a camera: blocks and results stay."


def stored_options(usual_units: float) -> ExportOptions:
    """Return the options of the last export, with the usual PNG units unless others were chosen."""
    if stored := QSettings().value(_OPTIONS_KEY):
        try:
            return ExportOptions(**{"depth_units": usual_units, **json.loads(str(stored))})
        except (ValueError, TypeError, RecursionError):
            # damaged: use the defaults
            QSettings().remove(_OPTIONS_KEY)
    return ExportOptions(depth_units=usual_units)


class OptionField:
    """The controls of a declared option: boxes to tick, a list to choose from, or both.

    Attributes
    ----------
    boxes : dict of str to QCheckBox
        Of several choices by their names, of one value by "".
    choice : QComboBox or None
    """

    def __init__(self, declaration: Declaration) -> None:
        self.declaration = declaration
        self.boxes: dict[str, QCheckBox] = {}
        self.choice: QComboBox | None = None
        choices, kind = declaration.choices, declaration.kind
        if kind is tuple:
            self.boxes = {name: QCheckBox(str(text)) for name, text in choices.items()}
        elif kind is bool or declaration.or_none:
            self.boxes = {"": check(declaration.label, declaration.help)}
        if kind is str:
            name = declaration.help.partition(".")[0] if self.boxes else declaration.label
            self.choice = combo(choices, declaration.help, name)
        elif kind in (int, float):
            self.choice = typed_list()
            self.choice.setToolTip(declaration.help)
            self.choice.setAccessibleName(declaration.label)

    def show_value(self, value: Any) -> None:
        """Show a value, of a list without others."""
        for name, box in self.boxes.items():
            box.setChecked(name in value if self.declaration.kind is tuple else bool(value))
        if self.choice is not None and self.declaration.kind in (int, float):
            texts = map(self.choice.itemText, range(self.choice.count()))
            number, unit, special = f"{value:.12g}", self.declaration.unit, self.declaration.special
            text = next((text for text in texts if text.split()[0] == number), f"{number} {unit}".strip())
            self.choice.setCurrentText(special if special and value == self.declaration.minimum else text)
        elif self.choice is not None:
            self.choice.setCurrentIndex(max(self.choice.findData(value), 0))

    def value(self, possible: bool) -> Any:
        """Return the value; if it must be `possible`, without boxes that are off. ParameterError if it is refused."""
        on = [name for name, box in self.boxes.items() if box.isChecked() and (box.isEnabled() or not possible)]
        if self.declaration.kind is tuple:
            return tuple(on)
        if self.choice is None:
            return bool(on)
        if self.declaration.kind in (int, float):
            label, text = self.declaration.label, self.choice.currentText().strip()
            if text and text == self.declaration.special:
                return self.declaration.minimum
            with told_as(ParameterError, f"{label} must be a number, not {text!r}.", ValueError):
                number = float(text.partition(" ")[0])
            return replace(self.declaration, name=label).checked(number)
        return self.choice.currentData() if on or not self.boxes else None

    def enable(self, on: bool) -> None:
        """Offer the option, or do not; a list beside a box is on while that is."""
        for box in self.boxes.values():
            box.setEnabled(on)
        if self.choice is not None:
            self.choice.setEnabled(on and all(box.isChecked() for box in self.boxes.values()))


class FilesForm(QWidget):
    """Which files are written of each frame: a field for each of the `ExportOptions`.

    Signals
    -------
    changed()
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._run: Run | None = None
        self._completion: Completion | None = None
        self.fields = {name: OptionField(one) for name, one in ExportOptions.declarations().items()}
        units = self.fields["depth_units"].choice
        assert units is not None
        self.png_units = units
        self.png_units.addItems(_PNG_UNITS)
        self.png_note, self.cloud_note = Message(lines=2), Message()
        self.cloud_note.show_message(_NO_INTRINSICS, "warning")
        self.restore(None)
        self._lay_out()
        for field in self.fields.values():
            for box in field.boxes.values():
                box.toggled.connect(self._update)
            if field.choice is not None:
                field.choice.currentTextChanged.connect(self._update)

    def restore(self, inputs: FrameInputs | None) -> None:
        """Restore the last choice, with the units of a frame's depth file unless others were chosen."""
        # depth in metres is fractional
        given = 0.0 if inputs is None else inputs.depth_units
        self._usual_units = given if given > 1 else ExportOptions().depth_units
        options = stored_options(self._usual_units)
        for name, field in self.fields.items():
            field.show_value(getattr(options, name))

    def describe(self, run: Run | None, completion: Completion | None = None) -> None:
        """Offer what is possible for the run of one frame; everything for None.

        `completion` is None if no block has a result: then there are no curves, and the depth is the input depth.
        """
        self._run, self._completion = run, completion
        self._update()

    def choose_none(self) -> None:
        """Write no files."""
        for field in self.fields.values():
            for box in field.boxes.values():
                box.setChecked(False)

    def options(self) -> ExportOptions:
        """Return the chosen options, without those that are not possible for the frame.

        Raises
        ------
        ParameterError
            If the PNG units are not a positive number.
        """
        return self._options(possible=True)

    def names(self) -> tuple[str, ...]:
        """Return the names of the files of a frame; raises as `options`."""
        options = self.options()
        return filenames(self._run, options) * bool(filenames(None, options))

    def store(self) -> None:
        """Remember the choice. What is not possible for this frame keeps its stored choice."""
        chosen = self._options(possible=False).to_dict()
        if chosen["depth_units"] == self._usual_units:
            del chosen["depth_units"]
        QSettings().setValue(_OPTIONS_KEY, json.dumps(chosen))

    def _options(self, possible: bool) -> ExportOptions:
        return ExportOptions(**{name: field.value(possible) for name, field in self.fields.items()})

    def _lay_out(self) -> None:
        """Lay out a box for each group of options, in two columns."""
        groups: dict[str, list[OptionField]] = {}
        for field in sorted(self.fields.values(), key=lambda field: not field.declaration.or_none):
            groups.setdefault(field.declaration.group, []).append(field)
        notes = {DEPTH: self.png_note, SPACE: self.cloud_note}
        columns = lay_out(QVBoxLayout(), spacing=12), lay_out(QVBoxLayout(), spacing=12)
        for number, (title, fields) in enumerate(groups.items()):
            box, column = group(title)
            for field in fields:
                _add_field(column, field)
            if title in notes:
                column.addWidget(notes[title])
            columns[2 * number // len(groups)].addWidget(box)
        for column in columns:
            column.addStretch(1)
        lay_out(QHBoxLayout(self), *columns, margins=(10, 10, 10, 10), spacing=12, stretched=columns)

    def _update(self) -> None:
        """Update what depends on the choice."""
        run, formats = self._run, self.fields["depth_formats"].value(possible=True)
        has_camera = run is None or run.frame.intrinsics is not None
        there = {
            "depth": bool(formats),
            "png": "png" in formats,
            "result": run is None or self._completion is not None,
            "camera": has_camera,
            "space": has_camera and any(self.fields[name].boxes[""].isChecked() for name in ("cloud", "mesh")),
        }
        for name, field in self.fields.items():
            needs, when = field.declaration.needs, field.declaration.when
            if unknown := set(needs) - there.keys():
                raise LookupError(f"The export option {name} needs {', '.join(unknown)}, which is not known here.")
            has_effect = not when or self.fields[when[0]].value(possible=True) in when[1:]
            field.enable(has_effect and all(there[need] for need in needs))
        for name, box in self.fields["exports"].boxes.items():
            why = "" if run is None else FORMATS[name].lacks(run)
            box.setEnabled(not why)
            box.setToolTip(literal_text(why or f"Written as {FORMATS[name].file}"))
        self.cloud_note.setVisible(not has_camera)
        self._tell_png_losses(run)
        self.changed.emit()

    def _tell_png_losses(self, run: Run | None) -> None:
        """Say below the units what the PNG of a frame loses."""
        try:
            units = self.fields["depth_units"].value(possible=True)
        except ParameterError as error:
            self.png_note.show_message(str(error), "error")
            return
        losses: list[str] = []
        if run is not None:
            given = 1.0 if run.frame.inputs is None else run.frame.inputs.depth_units
            depth = run.frame.depth if self._completion is None else self._completion.depth
            losses = [*png_losses(depth, units), *filter(None, [precision_loss(given, units)])]
        text = " ".join(losses) or f"Steps of {1000 / units:.3g} mm."
        self.png_note.show_message(text, "warning" if losses else "muted")


def _add_field(column: QVBoxLayout, field: OptionField) -> None:
    """Add the controls of an option to a column; several boxes are in pairs, which take half of its width each."""
    if len(field.boxes) > 1:
        pairs = QGridLayout()
        pairs.setColumnStretch(0, 1)
        pairs.setColumnStretch(1, 1)
        for number, box in enumerate(field.boxes.values()):
            pairs.addWidget(box, *divmod(number, 2))
        add_layout(column, pairs)
        return
    for box in field.boxes.values():
        column.addWidget(box)
    if field.choice is not None and field.boxes:
        column.addWidget(field.choice)
    elif field.choice is not None:
        add_layout(column, form((label_of(field.declaration.label, field.choice), field.choice)))


def check(text: str, hint: str) -> QCheckBox:
    """Return a box to check, with a hint."""
    box = QCheckBox(text)
    box.setToolTip(hint)
    return box

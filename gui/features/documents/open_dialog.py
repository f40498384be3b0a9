"""The dialog Open: it recognises what a path is, shows it, and asks for the reading options that apply."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from PySide6.QtCore import Qt
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QToolButton,
    QWidget,
)

from ilf.data.camera import INTRINSICS, is_preset
from ilf.errors import InputError
from ilf.io.camera_files import CAMERA_FILES
from ilf.io.depth_doubts import PlausibilityWarning
from ilf.io.encodings import ENCODING_DESCRIPTIONS
from ilf.io.images import read_colour
from ilf.sources.frame_ref import DEPTH_VIEW, OPTIONS, FrameRef, ReadingOptions
from ilf.sources.named_places import NotAllowed
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import recording_suffixes

from ...base.paths import PROJECT_SUFFIX
from ...widgets.basics import TAKES_FILES, combo, form, label_of, lay_out, row, stack, typed_list
from ...widgets.file_choice import choose_file, choose_folder, remember_folder
from ...work.latest_request import LatestRequest
from ..guide_networks import GIVES
from .file_dialogs import PreviewDialog
from .frame_files import (
    Kind,
    Look,
    files_of,
    guide_files,
    kind_of,
    look_at_file,
    look_at_frame,
    look_into,
    looks_like_depth,
    pair_of,
    recording_files,
    refused,
)

Field = TypeVar("Field", QLineEdit, QComboBox)

_NOTHING_SELECTED = (
    "Choose a colour image with its depth, a folder of frames, a recording, a project or the run.json of a run."
)
_NO_DEPTH = "Choose the depth file that belongs to this colour image."
_FOLDER_KEY = "open/folder"

_AUTOMATIC = "Automatic (as the files state, or by file type)"
_AS_STATED = "As the files state, or none"


class OpenDialog(PreviewDialog):
    """Dialog to choose what is opened, with a preview.

    *Open* is enabled only if the chosen files can be read, or the folder or recording may have frames.

    Parameters
    ----------
    looks : LatestRequest
        Looks into a folder of frames or a recording in a worker thread.
    """

    meanwhile = Look("Listing frames…")  # it can be opened already

    def __init__(self, looks: LatestRequest, parent: QWidget | None = None) -> None:
        placeholder = "Colour image, folder, data set, recording, project, or run.json"
        super().__init__("Open", placeholder, ("Colour", "Depth"), "", looks, parent)
        self._proposed_depth = ""
        self._doubts: tuple[PlausibilityWarning, ...] = ()
        self.setAcceptDrops(True)
        self.setProperty(TAKES_FILES, True)
        self._form, self._reading = form(), QWidget()
        self._reading_form = form(parent=self._reading)
        self._show_row: dict[QWidget, Callable[[bool], None]] = {}
        """Field -> shows or hides its row."""
        self._add_files()
        self._add_reading()
        self._add_camera()
        self._add_guide()
        self.apply_button = QPushButton("Apply suggestion")
        self.apply_button.setToolTip("Set the depth encoding or the invalid value that the message suggests.")
        policy = self.apply_button.sizePolicy()
        policy.setRetainSizeWhenHidden(True)  # keeps the layout still while typing
        self.apply_button.setSizePolicy(policy)
        self.apply_button.clicked.connect(self._apply_suggestions)
        self.more = QToolButton(autoRaise=True)
        self.more.setText("Reading options")
        self.more.setCheckable(True)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.more.setToolTip("How depth is read, with which camera, and a guide")
        self.more.toggled.connect(self._unfold)
        self._unfold(False)
        previews = lay_out(QHBoxLayout(), *self.previews, spacing=12)
        folded = row(self.more, self.apply_button)
        stack(self, self._form, previews, self.message, folded, self._reading, self.buttons, spacing=12)
        self.read()

    def _add_files(self) -> None:
        kinds = COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, recording_suffixes(), (PROJECT_SUFFIX, ".json")
        filters = files_of("All that can be opened", dict.fromkeys(sum(kinds, ())), recording_files())
        file = self._file_button("Choose what to open", filters, self._set_paths)
        folder = self.browse_button(
            "Folder…", lambda: choose_folder(self, "Choose folder", _FOLDER_KEY), self._set_paths
        )
        self.depth_path = QLineEdit(placeholderText="Raw depth: 16-bit or float, one channel")
        self._add("&Path", self.path, "", file, folder)
        depth_files = files_of("Depth", DEPTH_FILE_SUFFIXES)
        depth = self._file_button(
            "Choose depth file", depth_files, lambda path: self._set_paths(self.path.text(), path)
        )
        self._add("&Depth", self.depth_path, "", depth)
        self.depth_path.setToolTip("One of several datasets of an HDF5 file is named behind it: FILE.h5:/depth.")

    def _add_reading(self) -> None:
        names = typed_list()
        names.addItems([_AUTOMATIC, *(f"{name} ({meaning})" for name, meaning in ENCODING_DESCRIPTIONS.items())])
        self.encoding = self._add("Depth &encoding", names, "encoding")
        line = QLineEdit(placeholderText="In HDF5 files: the only one that can be depth")
        self.dataset = self._add("Data&set", line, "dataset")
        self.invalid = self._add("In&valid value", QLineEdit(placeholderText="Zero only; 65535 in 7-Scenes"), "invalid")
        line = QLineEdit(placeholderText="None: all depth counts")
        self.min_confidence = self._add("&Min. confidence", line, "min_confidence")

    def _add_camera(self) -> None:
        cameras = typed_list()
        cameras.addItems([_AS_STATED, *INTRINSICS])
        file = self._file_button("Choose intrinsics", files_of("Intrinsics", CAMERA_FILES), cameras.setEditText)
        self.undistort = QCheckBox("Undistort")
        self.undistort.setToolTip(_hint("undistort"))
        self.undistort.toggled.connect(self.schedule)
        self.camera = self._add("Camera &intrinsics", cameras, "intrinsics", file, self.undistort)
        self.view = self._add("Pi&xels of", combo({None: "Colour camera", DEPTH_VIEW: "Depth camera"}), "view")

    def _add_guide(self) -> None:
        self.guide_path = QLineEdit(placeholderText="Depth or inverse depth from elsewhere (optional)")
        file = self._file_button("Choose guide", guide_files(), self.guide_path.setText)
        self._add("&Guide", self.guide_path, "guide", file)
        kinds = combo({None: "a value that rises or falls with depth", **GIVES})
        self.guide_gives = self._add("&What it gives", kinds, "guide_gives")
        for choice in (self.encoding, self.camera, self.guide_gives):  # no wider than the pictures
            choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            choice.setMinimumContentsLength(12)

    def _add(self, text: str, field: Field, option: str, *beside: QWidget) -> Field:
        """Add a field, with what is said of its reading option: files above the pictures, others below them."""
        if option:
            field.setToolTip(_hint(option))
        field.setAccessibleName(text.replace("&", ""))
        changed = field.textChanged if isinstance(field, QLineEdit) else field.currentTextChanged
        changed.connect(self.schedule)
        line = QWidget()
        lay_out(QHBoxLayout(line), field, *beside, stretched=field, spacing=8)
        fields = self._form if field in (self.path, self.depth_path) else self._reading_form
        fields.addRow(label_of(text, field), line)
        self._show_row[field] = partial(fields.setRowVisible, line)
        return field

    def _file_button(self, title: str, filters: str, take: Callable[[str], object]) -> QPushButton:
        return self.browse_button("File…", lambda: choose_file(self, title, _FOLDER_KEY, filters), take)

    def set_files(self, rgb: str, depth: str | None = None) -> None:
        """Set the files: two files in either order, one file, a folder, or a recording.

        The other file of a pair is proposed if only one is given.
        """
        if depth is None:
            remember_folder(_FOLDER_KEY, rgb)
            self._set_paths(rgb, self.depth_path.text() if kind_of(rgb) is Kind.PAIR else "")
        else:
            swapped = looks_like_depth(Path(rgb)) and not looks_like_depth(Path(depth))
            self._set_paths(depth if swapped else rgb, rgb if swapped else depth)

    @property
    def kind(self) -> Kind:
        """What the path is."""
        return kind_of(self._paths()[0])

    def request(self) -> FrameRef:
        """Return the frame or the frames to open.

        Raises
        ------
        InputError
            If files are missing, or the invalid value or the minimum confidence is no number.
        """
        (colour, depth), kind = self._paths(), self.kind
        if kind is Kind.NOTHING or (kind is Kind.PAIR and not depth):
            raise InputError(_NOTHING_SELECTED)
        encoding = self.encoding.currentText().partition(" (")[0].strip()  # a name, or a number as text
        options = ReadingOptions(
            encoding=None if encoding in ("", _AUTOMATIC.partition(" (")[0]) else encoding,
            dataset=(self.dataset.text().strip() or None) if kind in (Kind.FRAME, Kind.FRAMES) else None,
            invalid=_number(self.invalid, "The invalid value must be a number of the depth file, such as 65535"),
            min_confidence=_number(
                self.min_confidence, "The minimum confidence must be a number of the confidence map, such as 2"
            ),
            intrinsics=self._intrinsics(),
            undistort=(self.undistort.isChecked() and self._states_lens(kind)) or None,
            view=self.view.currentData(),
            guide=self.guide_path.text().strip() or None if kind in (Kind.PAIR, Kind.FRAME) else None,
            guide_gives=self.guide_gives.currentData() if kind in (Kind.PAIR, Kind.FRAME) else None,
        )
        return FrameRef(colour, depth if kind is Kind.PAIR else None, options=options)

    def look(self) -> Look | Callable[[], Look]:
        self._propose_partner()
        (colour, depth), kind = self._paths(), self.kind
        self._offer_options(kind)
        if kind is Kind.NOTHING:
            return self.refused(_NOTHING_SELECTED, "muted")
        if kind in (Kind.PROJECT, Kind.RUN):
            return look_at_file(Path(colour))
        if kind is Kind.PAIR and not depth:
            read_colour(colour)  # reports an error of this file before asking for the other one
            return self.refused(_NO_DEPTH, "muted")
        request = self.request()
        return partial(look_into, request) if kind is Kind.FRAMES else look_at_frame(request)

    def _propose_partner(self) -> None:
        """Propose the depth beside a colour file, or the colour beside depth; a depth file that was chosen stays."""
        colour, depth = self._paths()
        if self.kind is not Kind.PAIR or depth not in ("", self._proposed_depth):
            return
        pair = pair_of(Path(colour))
        if pair is not None or depth:
            rgb, self._proposed_depth = (colour, "") if pair is None else (str(pair[0]), str(pair[1]))
            self._write_paths(rgb, self._proposed_depth)

    def _offer_options(self, kind: Kind) -> None:
        """Show the reading options that apply, and those only."""
        of_images, is_pair = kind in (Kind.PAIR, Kind.FRAME, Kind.FRAMES), kind is Kind.PAIR
        self._show_row[self.depth_path](is_pair)
        self._show_row[self.dataset](of_images and not is_pair)  # a pair names the dataset behind its depth
        for field in (self.guide_path, self.guide_gives):
            self._show_row[field](kind in (Kind.PAIR, Kind.FRAME))
        self.undistort.setVisible(self._states_lens(kind))
        self.more.setVisible(of_images)
        self._reading.setVisible(of_images and self.more.isChecked())
        for preview in (self.colour_preview, self.depth_preview):
            preview.setVisible(kind not in (Kind.PROJECT, Kind.RUN))

    def _unfold(self, on: bool) -> None:
        """Show or hide the reading options, below the pictures, which stay in their place."""
        self.more.setArrowType(Qt.ArrowType.DownArrow if on else Qt.ArrowType.RightArrow)
        self._reading.setVisible(on)
        self.adjustSize()

    def files(self) -> Sequence[str]:
        return (*self._paths(), self.guide_path.text().strip())

    def refused(self, text: str, tone: str) -> Look:
        return refused(text, tone, *self._paths(), self.request)

    def fail(self, error: Exception) -> None:
        """Say why the choice cannot be opened, or what a file names elsewhere, about which the window asks then."""
        if isinstance(error, NotAllowed):
            places = " and ".join(error.places)
            text = f"A file names {places} outside its own folder, which was never opened here: Open asks first."
            self.show_look(Look(text, "warning"))
        else:
            super().fail(error)

    def show_look(self, look: Look) -> None:
        """Show what is seen of the choice; the dialog grows for the message if it must."""
        super().show_look(look)
        if (layout := self.layout()) is not None:
            self.resize(self.width(), max(self.height(), layout.totalHeightForWidth(self.width())))
        self._doubts = tuple(doubt for doubt in look.doubts if doubt.encoding is not None or doubt.invalid is not None)
        self.apply_button.setVisible(bool(self._doubts))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Open by Enter, also while a change is waiting to be read."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.accept()
        else:
            super().keyPressEvent(event)

    def accept(self) -> None:
        """Open what can be read, once."""
        if self.result() == QDialog.DialogCode.Accepted:
            return
        self.read()  # a change may still be waiting
        if self.accept_button.isEnabled():
            super().accept()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if event.mimeData().hasUrls():
            event.setDropAction(Qt.DropAction.CopyAction)
            event.accept()

    def dropEvent(self, event: QDropEvent) -> None:
        """Choose what is dropped: a path, or the two files of a pair."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.setDropAction(Qt.DropAction.CopyAction)
        event.accept()
        if paths:
            self.depth_path.clear()
            self.set_files(*paths[:2])

    def _apply_suggestions(self) -> None:
        for doubt in self._doubts:
            if doubt.encoding is not None:
                row = self.encoding.findText(f"{doubt.encoding} (", Qt.MatchFlag.MatchStartsWith)
                self.encoding.setCurrentIndex(row)
            if doubt.invalid is not None:
                self.invalid.setText(f"{doubt.invalid:.9g}")
        self.more.setChecked(True)  # to see what was set
        self.read()

    def _states_lens(self, kind: Kind) -> bool:
        """Whether the distortion of the lens can be stated, in a file of intrinsics or in those of a data set."""
        given = self._intrinsics()
        return kind is Kind.FRAMES if given is None else isinstance(given, str) and not is_preset(given)

    def _set_paths(self, path: str, depth: str = "") -> None:
        self._write_paths(path, depth)
        self.read()

    def _write_paths(self, path: str, depth: str) -> None:
        if path != self.path.text():  # the cursor stays where it is
            self.path.setText(path)
        self.depth_path.setText(depth)

    def _paths(self) -> tuple[str, str]:
        return self.path.text().strip(), self.depth_path.text().strip()

    def _intrinsics(self) -> str | tuple[float, ...] | None:
        """Return four numbers, the name of a preset, or a file, which may stand beside colour."""
        text = self.camera.currentText().strip()
        if text in ("", _AS_STATED):
            return None
        try:
            return tuple(float(part) for part in text.replace(",", " ").split())
        except ValueError:
            return str(Path(self._paths()[0]).parent / text) if "." in text else text  # messages leave out the folder


def _hint(option: str) -> str:
    """Return what is said of a reading option, as a sentence."""
    text = OPTIONS[option].help
    return f"{text[:1].upper()}{text[1:]}."


def _number(field: QLineEdit, demand: str) -> float | None:
    """Return the number in a field, None if it is empty; InputError, starting with `demand`, if it is no number."""
    text = field.text().strip()
    try:
        return float(text) if text else None
    except ValueError as error:
        raise InputError(f"{demand}, not {text!r}.") from error

"""Dialog that opens a frame: files, depth encoding and camera intrinsics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, QTimer
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf._runtime.named_places import NotAllowed
from ilf.data.camera import INTRINSICS
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError, InputError
from ilf.io.camera_files import CAMERA_FILES
from ilf.io.depth import read_depth_values
from ilf.io.depth_reading import PlausibilityWarning
from ilf.io.encodings import ENCODING_DESCRIPTIONS, encoding_of_inputs, is_name
from ilf.io.images import read_colour
from ilf.sources.frame_folder import frame_folder
from ilf.sources.frame_ref import FrameRef
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import is_recording
from ilf.sources.reading import described_beside, read_depth, read_frame
from ilf.sources.reading_options import ReadingOptions

from ...widgets.basics import Message, PlainLabel
from ...widgets.file_choice import choose_file, choose_folder, remember_folder
from ...widgets.notices import error_text
from ...work.latest_request import LatestRequest
from ...work.loading import FolderPreview, contains_frames
from .file_dialogs import Preview
from .frame_files import guide_files, matching_colour_file, matching_depth_file, recording_files

_Result = TypeVar("_Result")

_NOTHING_SELECTED = "Choose a colour file and its depth file, a folder of frames, or a recording."
_NO_DEPTH = "Choose the depth file that belongs to this colour image."
_FOLDER_KEY = "open/folder"
_DELAY_MS = 200

_AUTOMATIC = "Automatic (from meta.json, or by file type)"
_FROM_META, _NUMBERS, _FILE = (
    "From meta.json, or none (needed for point clouds only)",
    "Numbers: fx, fy, cx, cy",
    "From a file",
)


class OpenFrameDialog(QDialog):
    """Dialog to choose a frame, a folder of frames or a recording, with a preview.

    *Open* is enabled only if `ilf.io.load_frame` can read the chosen files, or the folder or recording may have frames.

    Parameters
    ----------
    looks : LatestRequest
        Computes the `FolderPreview` of a folder of frames or a recording in a worker thread.
    """

    def __init__(self, looks: LatestRequest[FrameRef, FolderPreview], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._looks = looks
        self._wanted: FrameRef | None = None
        """Source whose `FolderPreview` is pending."""
        looks.answered.connect(self._show_first)
        looks.failed.connect(self._refuse_source)
        self.setWindowTitle("Open Frame")
        self._reading_delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._reading_delay.timeout.connect(self.read)

        self.colour_path = QLineEdit(placeholderText="Colour image, folder of frames, or recording")
        self.depth_path = QLineEdit(placeholderText="Raw depth: 16-bit or float, one channel")
        self.guide_path = QLineEdit(placeholderText="Depth or inverse depth from elsewhere (optional)")
        self.encoding = QComboBox(editable=True)
        self.encoding.addItems(
            [_AUTOMATIC, *(f"{name} ({meaning})" for name, meaning in ENCODING_DESCRIPTIONS.items())]
        )
        self.encoding.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.encoding.setToolTip(
            "How the values of the file become metres: a name, or the number of file units per metre. Automatic: from "
            "meta.json; without it, millimetres for integer depth and metres for floating-point depth."
        )
        self.invalid = QLineEdit(placeholderText="Zero only; 65535 in 7-Scenes")
        self.invalid.setToolTip(
            "The value of the file that means missing depth, in addition to zero; 0 if there is none."
        )
        self.min_confidence = QLineEdit(placeholderText="None: all depth counts")
        self.min_confidence.setToolTip(
            "Depth of lower confidence counts as missing, if the frame has a confidence map (2 = ARKit high)."
        )
        self.camera = QComboBox()
        self.camera.addItems([_FROM_META, *INTRINSICS, _NUMBERS, _FILE])
        self.camera_text = QLineEdit()
        self.camera_text.setAccessibleName("Intrinsics: numbers or file")
        self.camera_browse = QPushButton("File…", autoDefault=False)
        self.message = Message(lines=7)
        self.apply_button = QPushButton("Apply suggestion", autoDefault=False)
        self.apply_button.setToolTip("Set the depth encoding or the invalid value that the message suggests.")
        policy = self.apply_button.sizePolicy()
        policy.setRetainSizeWhenHidden(True)  # keeps the layout still while typing
        self.apply_button.setSizePolicy(policy)
        self.apply_button.clicked.connect(self._apply_suggestions)
        self._doubts: tuple[PlausibilityWarning, ...] = ()
        self.colour_preview, self.depth_preview = Preview("Colour"), Preview("Depth")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Open | QDialogButtonBox.StandardButton.Cancel)
        self.open_button = buttons.button(QDialogButtonBox.StandardButton.Open)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)

        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(12)
        layout.addLayout(self._form())
        previews = QHBoxLayout()
        previews.setSpacing(12)
        previews.addWidget(self.colour_preview)
        previews.addWidget(self.depth_preview)
        layout.addLayout(previews)
        layout.addWidget(self.message)
        layout.addWidget(self.apply_button, alignment=Qt.AlignmentFlag.AlignLeft)
        layout.addStretch(1)
        layout.addWidget(buttons)

        self.colour_path.textChanged.connect(self._schedule)
        self.depth_path.textChanged.connect(self._schedule)
        self.guide_path.textChanged.connect(self._schedule)
        self.encoding.editTextChanged.connect(self._schedule)
        editor = self.encoding.lineEdit()
        if editor is not None:
            editor.returnPressed.connect(self.accept)  # the completion of its text swallows the key
        self.invalid.textChanged.connect(self._schedule)
        self.min_confidence.textChanged.connect(self._schedule)
        self.camera_text.textChanged.connect(self._schedule)
        self.camera.currentTextChanged.connect(self._change_camera)
        self._change_camera()
        self.read()

    def set_files(self, rgb: str, depth: str | None = None) -> None:
        """Set the files: two files in either order, one file, a folder, or a recording.

        The other file of a pair is proposed if only one is given.
        """
        if depth is None:
            remember_folder(_FOLDER_KEY, rgb)
            self._choose(Path(rgb), _looks_like_depth(Path(rgb)))
        else:
            swapped = _looks_like_depth(Path(rgb)) and not _looks_like_depth(Path(depth))
            self._set_paths(depth if swapped else rgb, rgb if swapped else depth)

    def request(self) -> FrameRef:
        """Return the source to open.

        Raises
        ------
        InputError
            If files are missing, the depth encoding is unknown, or the invalid value, the minimum confidence or
            the intrinsics are not numbers.
        """
        colour, depth = self._paths()
        is_whole = _needs_no_depth(colour)
        if not colour or not (depth or is_whole):
            raise InputError(_NOTHING_SELECTED)
        guide = self.guide_path.text().strip() or None
        pair = (colour, None if is_whole else depth)
        units, name = self._encoding()
        options = ReadingOptions(
            encoding=name,
            depth_units=units,
            invalid=_number(self.invalid, "The invalid value must be a number of the depth file, such as 65535"),
            min_confidence=_number(
                self.min_confidence, "The minimum confidence must be a number of the confidence map, such as 2"
            ),
            intrinsics=self._intrinsics(),
            guide=guide,
        )
        return FrameRef(*pair, options=options)

    def read(self) -> None:
        """Read the chosen files and describe them."""
        self._reading_delay.stop()
        self._wanted = None
        self._looks.forget()
        colour, depth = self._paths()
        self.depth_path.setEnabled(not _needs_no_depth(colour))
        if not colour and not depth:
            self._refuse(_NOTHING_SELECTED, "muted")
            return
        try:
            if not (depth or _needs_no_depth(colour)):
                read_colour(colour)  # reports an error of this file before asking for the other one
                self._refuse(_NO_DEPTH, "muted")
                return
            source = self.request()
            if contains_frames(colour):
                self._look_into(source)
                return
            frame = read_frame(source)
        except NotAllowed as error:
            self._announce_question(error)
        except IlfError as error:
            self._refuse(str(error), "error")
        else:
            text = " ".join(filter(None, (_describe_frame(frame), described_beside(source))))
            self._show(frame, text, read_depth(source).plausibility_warnings if frame.notes else ())

    def _show(self, frame: RGBDFrame, text: str, plausibility_warnings: Iterable[PlausibilityWarning]) -> None:
        self.colour_preview.show_rgb(frame.rgb)
        self.depth_preview.show_depth(frame.depth)
        self.message.show_message("\n".join((text, *frame.notes)), "warning" if frame.notes else "good")
        self._propose(plausibility_warnings)
        self.open_button.setEnabled(True)

    def _look_into(self, source: FrameRef) -> None:
        """List the frames in a worker thread; meanwhile the source can be opened already."""
        if source.options.guide is not None:
            raise InputError("A guide belongs to a single frame. Clear it here, and load a guide for each frame later.")
        self._show_nothing()
        self.message.show_message("Listing frames…", "text")
        self.open_button.setEnabled(True)
        self._wanted = source
        self._looks.ask(source)

    def _show_first(self, source: FrameRef, look: FolderPreview) -> None:
        if source != self._wanted:
            return
        frames = f"{counted(len(look.listing.sources), 'frame')} found."
        text = " ".join((frames, *look.listing.notes))
        if look.frame is None:
            self.message.show_message(f"{text}\nThe first frame cannot be read: {look.problem}", "warning")
        else:
            self._show(look.frame, f"{text} First frame:\n{_describe_frame(look.frame)}", look.plausibility_warnings)

    def _refuse_source(self, source: FrameRef, error: Exception) -> None:
        if source != self._wanted:
            return
        if isinstance(error, NotAllowed):
            self._announce_question(error)
        else:
            self._refuse(error_text(error), "error")

    def _announce_question(self, error: NotAllowed) -> None:
        """Say what a file names elsewhere; the window asks about it after *Open*."""
        self._show_nothing()
        places = " and ".join(error.places)
        self.message.show_message(
            f"A file names {places} outside its own folder, which was never opened here: Open asks first.", "warning"
        )
        self.open_button.setEnabled(True)

    def _show_nothing(self) -> None:
        self.colour_preview.show_rgb(None)
        self.depth_preview.show_depth(None)
        self._propose(())

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
        if self.open_button.isEnabled():
            super().accept()

    def done(self, result: int) -> None:
        self._reading_delay.stop()
        self._looks.forget()
        super().done(result)

    def _form(self) -> QGridLayout:
        colour_file = QPushButton("File…", autoDefault=False)
        folder = QPushButton("Folder…", autoDefault=False)
        depth_file = QPushButton("File…", autoDefault=False)
        guide_file = QPushButton("File…", autoDefault=False)
        colour_file.clicked.connect(lambda: self._browse(False))
        depth_file.clicked.connect(lambda: self._browse(True))
        guide_file.clicked.connect(self._browse_guide)
        folder.clicked.connect(self._browse_folder)
        self.camera_browse.clicked.connect(self._browse_camera)
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(8)
        grid.setColumnStretch(1, 1)
        for row, text, field in (
            (0, "&Colour or folder", self.colour_path),
            (1, "&Depth", self.depth_path),
            (2, "Depth &encoding", self.encoding),
            (3, "In&valid value", self.invalid),
            (4, "&Min. confidence", self.min_confidence),
            (5, "Camera &intrinsics", self.camera),
            (7, "&Guide", self.guide_path),
        ):
            label = PlainLabel(text)
            label.setBuddy(field)
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1, 1, 3 if isinstance(field, QComboBox) else 1)
        grid.addWidget(colour_file, 0, 2)
        grid.addWidget(folder, 0, 3)
        grid.addWidget(depth_file, 1, 2)
        grid.addWidget(self.camera_text, 6, 1)
        grid.addWidget(self.camera_browse, 6, 2, 1, 2)
        grid.addWidget(guide_file, 7, 2)
        return grid

    def _propose(self, plausibility_warnings: Iterable[PlausibilityWarning]) -> None:
        """Offer to apply the suggestions of plausibility warnings."""
        self._doubts = tuple(
            doubt for doubt in plausibility_warnings if doubt.encoding is not None or doubt.invalid is not None
        )
        self.apply_button.setVisible(bool(self._doubts))

    def _apply_suggestions(self) -> None:
        for doubt in self._doubts:
            if doubt.encoding is not None:
                row = self.encoding.findText(f"{doubt.encoding} (", Qt.MatchFlag.MatchStartsWith)
                self.encoding.setCurrentIndex(row)
            if doubt.invalid is not None:
                self.invalid.setText(f"{doubt.invalid:.9g}")
        self.read()

    def _schedule(self) -> None:
        self.open_button.setEnabled(False)
        self._reading_delay.start()

    def _change_camera(self) -> None:
        choice = self.camera.currentText()
        self.camera_text.setVisible(choice in (_NUMBERS, _FILE))
        self.camera_browse.setVisible(choice == _FILE)
        self.camera_text.setPlaceholderText(
            "Pixels, such as 525, 525, 319.5, 239.5"
            if choice == _NUMBERS
            else "JSON, YAML or text; FILE#NAME for one of several"
        )
        self._schedule()

    def _browse(self, is_depth: bool) -> None:
        what, suffixes = ("depth", DEPTH_FILE_SUFFIXES) if is_depth else ("colour", COLOUR_SUFFIXES)
        patterns = " ".join(f"*{suffix}" for suffix in suffixes)
        recordings = "" if is_depth else f"{recording_files()};;"
        filters = f"{what.capitalize()} ({patterns});;{recordings}All files (*)"
        if path := choose_file(self, f"Choose {what} file", _FOLDER_KEY, filters):
            self._choose(Path(path), is_depth)

    def _browse_folder(self) -> None:
        if path := choose_folder(self, "Choose frame folder", _FOLDER_KEY):
            self._choose(Path(path), False)

    def _browse_camera(self) -> None:
        patterns = " ".join(f"*{suffix}" for suffix in CAMERA_FILES)
        filters = f"Intrinsics ({patterns});;All files (*)"
        if path := choose_file(self, "Choose intrinsics", _FOLDER_KEY, filters):
            self.camera_text.setText(path)

    def _browse_guide(self) -> None:
        if path := choose_file(self, "Choose guide", _FOLDER_KEY, guide_files()):
            self.guide_path.setText(path)

    def _choose(self, path: Path, is_depth: bool) -> None:
        """Set one chosen path, and propose its partner; without a partner, the other field stays."""
        if path.is_dir():
            self._set_paths(str(path), "")
        elif is_depth:
            partner = matching_colour_file(path)
            self._set_paths(str(partner) if partner else self.colour_path.text(), str(path))
        else:
            partner = matching_depth_file(path)
            self._set_paths(str(path), str(partner) if partner else self.depth_path.text())

    def _set_paths(self, colour: str, depth: str) -> None:
        with QSignalBlocker(self.colour_path), QSignalBlocker(self.depth_path):
            self.colour_path.setText(colour)
            self.depth_path.setText(depth)
        self.read()

    def _paths(self) -> tuple[str, str]:
        return self.colour_path.text().strip(), self.depth_path.text().strip()

    def _encoding(self) -> tuple[float | None, str | None]:
        """Return the units per metre if a number was entered, and the name of an encoding."""
        text = self.encoding.currentText().strip()
        chosen = None if text == _AUTOMATIC else text.partition(" (")[0]
        try:
            return None if chosen is None else float(chosen), None
        except ValueError as error:
            if not is_name(chosen):
                raise InputError(
                    f"The depth encoding must be one of the list, or a number of file units per metre, not {chosen!r}."
                ) from error
            return None, chosen

    def _intrinsics(self) -> str | tuple[float, ...] | None:
        choice, text = self.camera.currentText(), self.camera_text.text().strip()
        if choice == _FROM_META:
            return None
        if choice == _FILE:
            if not text:
                raise InputError("Choose the file with the intrinsics.")
            return text
        if choice != _NUMBERS:
            return choice
        try:
            fx, fy, cx, cy = (float(part) for part in text.replace(",", " ").split())
        except ValueError as error:
            raise InputError(
                "The intrinsics must be four numbers in pixels: fx, fy, cx, cy, such as 525, 525, 319.5, 239.5."
            ) from error
        return fx, fy, cx, cy

    def _refuse(self, text: str, tone: str) -> None:
        """Show why the frame cannot be opened, with a preview of what can be read."""
        self.open_button.setEnabled(False)
        colour, depth = self._paths()
        files = colour, depth, self.guide_path.text().strip()
        for path in {str(Path(file).parent) for file in files} - {"."}:
            text = text.replace(f"{path}/", "")
        self.message.show_message(text, tone)
        self._propose(
            _try_read(lambda: read_depth(self.request()).plausibility_warnings) or () if tone == "error" else ()
        )
        if _is_folder(colour):
            found = _try_read(lambda: frame_folder(colour))
            colour, depth = (str(found.rgb), str(found.depth)) if found else ("", "")
        self.colour_preview.show_rgb(_try_read(lambda: read_colour(colour)) if colour else None)
        self.depth_preview.show_depth(_try_read(lambda: read_depth_values(depth)) if depth else None)


def _describe_frame(frame: RGBDFrame) -> str:
    """Describe a frame: depth, size and encoding in the first line, then guide and intrinsics."""
    known = frame.depth[frame.known]
    height, width = frame.shape
    encoding = "" if frame.inputs is None else encoding_of_inputs(frame.inputs).text
    first = (
        f"Median {np.median(known):.2f} m, range {known.min():.2f}–{known.max():.2f} m, {width} x {height}, "
        f"{100 * frame.missing_share:.0f} % missing{_outside(frame)}, {encoding}."
    )
    if frame.guide is not None:
        covered = np.isfinite(frame.guide.values[~frame.known])
        first += f"\nThe guide covers {100 * covered.mean() if covered.size else 100:.0f} % of the missing pixels."
    if frame.intrinsics is None:
        return f"{first}\nNo intrinsics: a point cloud is not possible."
    camera = frame.intrinsics
    return f"{first}\nIntrinsics: fx {camera.fx:g}, fy {camera.fy:g}, cx {camera.cx:g}, cy {camera.cy:g} px."


def _outside(frame: RGBDFrame) -> str:
    return f", {100 * frame.outside_share:.0f} % outside the depth camera's view" if frame.outside_share else ""


def _try_read(read: Callable[[], _Result]) -> _Result | None:
    """Return what can be read for a preview, else None; the message contains the error already."""
    try:
        return read()
    except IlfError:
        return None


def _number(field: QLineEdit, demand: str) -> float | None:
    """Return the number in a field, None if it is empty; InputError, starting with `demand`, if it is no number."""
    text = field.text().strip()
    try:
        return float(text) if text else None
    except ValueError as error:
        raise InputError(f"{demand}, not {text!r}.") from error


def _is_folder(path: str) -> bool:
    return bool(path) and Path(path).is_dir()


def _needs_no_depth(path: str) -> bool:
    """Whether a path needs no second file."""
    return _is_folder(path) or is_recording(path)


def _looks_like_depth(path: Path) -> bool:
    return "depth" in path.stem.lower() or path.suffix.lower() in set(DEPTH_FILE_SUFFIXES) - set(COLOUR_SUFFIXES)

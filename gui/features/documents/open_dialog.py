"""The dialog Open: it recognises what a path is, shows it, and asks for the reading options that apply."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, QTimer
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QToolButton,
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
from ilf.io.hdf5 import split_dataset
from ilf.io.images import read_colour
from ilf.project.file import open_project
from ilf.run.record_file import read_record
from ilf.sources.frame_folder import frame_folder
from ilf.sources.frame_ref import FrameRef
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import recording_suffixes
from ilf.sources.own_results import RECORD_FILE, is_result_folder
from ilf.sources.reading import described_beside, read_depth, read_frame
from ilf.sources.reading_options import DEPTH_VIEW, OPTIONS, ReadingOptions

from ...base.paths import PROJECT_SUFFIX
from ...project.loading import FolderPreview, contains_frames, preview_folder
from ...widgets.basics import TAKES_FILES, Message, answers, combo, form, label_of, lay_out, row, stack, typed_list
from ...widgets.file_choice import choose_file, choose_folder, remember_folder
from ...widgets.notices import error_text
from ...work.latest_request import LatestRequest
from ..guide_networks import GIVES
from .file_dialogs import Preview
from .frame_files import files_of, guide_files, looks_like_depth, pair_of, recording_files

_Result = TypeVar("_Result")
Field = TypeVar("Field", QLineEdit, QComboBox)

_NOTHING_SELECTED = (
    "Choose a colour image with its depth, a folder of frames, a recording, a project or the run.json of a run."
)
_NO_DEPTH = "Choose the depth file that belongs to this colour image."
_FOLDER_KEY = "open/folder"
_DELAY_MS = 200
_MAX_NAMED = 5

_AUTOMATIC = "Automatic (as the files state, or by file type)"
_AS_STATED, _NUMBERS, _FILE = (
    "As the files state, or none (needed for point clouds only)",
    "Four numbers",
    "From a file",
)
_VIEWS = {"Colour camera": None, "Depth camera": DEPTH_VIEW}
"""The camera whose pixels the frame has -> reading option."""


class Kind(Enum):
    """What a path is, by names only."""

    NOTHING, PAIR, FRAME, FRAMES, PROJECT, RUN = range(6)


def kind_of(path: str) -> Kind:
    """Recognise a path: of a pair of images, the folder of a frame, of frames or a recording, a project, or a run or
    the folder with its result."""
    if not path:
        return Kind.NOTHING
    if Path(path).suffix.lower() == PROJECT_SUFFIX:
        return Kind.PROJECT
    if contains_frames(path):
        return Kind.FRAMES
    if Path(path).is_dir():
        return Kind.RUN if is_result_folder(FrameRef(path)) else Kind.FRAME
    return Kind.RUN if Path(path).suffix.lower() == ".json" else Kind.PAIR


class OpenDialog(QDialog):
    """Dialog to choose what is opened, with a preview.

    *Open* is enabled only if the chosen files can be read, or the folder or recording may have frames.

    Parameters
    ----------
    looks : LatestRequest
        Lists folders of frames and recordings.
    """

    def __init__(self, looks: LatestRequest, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._looks = looks
        self._proposed_depth = ""
        self._doubts: tuple[PlausibilityWarning, ...] = ()
        self.setWindowTitle("Open")
        self.setAcceptDrops(True)
        self.setProperty(TAKES_FILES, True)
        self._reading_delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._reading_delay.timeout.connect(self.read)
        self._form, self._reading = form(), QWidget()
        self._reading_form = form(parent=self._reading)
        self._rows: dict[QWidget, tuple[QFormLayout, QWidget]] = {}
        """Field -> its form and line."""
        self._add_files()
        self._add_reading()
        self._add_camera()
        self._add_guide()
        self.message = Message(lines=5)
        self.apply_button = QPushButton("Apply suggestion", autoDefault=False)
        self.apply_button.setToolTip("Set the depth encoding or the invalid value that the message suggests.")
        policy = self.apply_button.sizePolicy()
        policy.setRetainSizeWhenHidden(True)  # keeps the layout still while typing
        self.apply_button.setSizePolicy(policy)
        self.apply_button.clicked.connect(self._apply_suggestions)
        self.colour_preview, self.depth_preview = Preview("Colour"), Preview("Depth")
        buttons, self.open_button = answers(self, QDialogButtonBox.StandardButton.Open)
        self.more = QToolButton(autoRaise=True)
        self.more.setText("Reading options")
        self.more.setCheckable(True)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.more.setToolTip("How depth is read, with which camera, and a guide")
        self.more.toggled.connect(self._unfold)
        self._unfold(False)
        previews = lay_out(QHBoxLayout(), self.colour_preview, self.depth_preview, spacing=12)
        folded = row(self.more, self.apply_button)
        stack(self, self._form, previews, self.message, folded, self._reading, buttons, spacing=12)
        self._change_camera()
        self.read()

    def _add_files(self) -> None:
        kinds = COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, recording_suffixes(), (PROJECT_SUFFIX, ".json")
        filters = files_of("All that can be opened", dict.fromkeys(sum(kinds, ())), recording_files())
        file = self._file_button("Choose what to open", filters, self._take_path)
        folder = self._button("Folder…", lambda: choose_folder(self, "Choose folder", _FOLDER_KEY), self._take_path)
        texts = (
            "Colour image, folder, data set, recording, project, or run.json",
            "Raw depth: 16-bit or float, one channel",
        )
        self.path, self.depth_path = (QLineEdit(placeholderText=text) for text in texts)
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
        self.camera_text = QLineEdit()
        self.camera_text.setAccessibleName("Intrinsics: numbers or file")
        self.camera_text.textChanged.connect(self._schedule)
        camera_files = files_of("Intrinsics", CAMERA_FILES)
        self.camera_browse = self._file_button("Choose intrinsics", camera_files, self.camera_text.setText)
        self.undistort = QCheckBox("Undistort")
        self.undistort.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)  # the choice has the rest
        self.undistort.setToolTip(
            "Correct the lens distortion that the file states, of colour and depth: the camera of the frame and of all "
            "results is that of the corrected images."
        )
        self.undistort.toggled.connect(self._schedule)
        beside = self.camera_text, self.camera_browse, self.undistort
        choices = [_AS_STATED, *INTRINSICS, _NUMBERS, _FILE]
        self.camera = self._add("Camera &intrinsics", combo(choices), "", *beside)
        self.camera.currentTextChanged.connect(self._change_camera)
        self.view = self._add("Pi&xels of", combo([*_VIEWS]), "view")

    def _add_guide(self) -> None:
        self.guide_path = QLineEdit(placeholderText="Depth or inverse depth from elsewhere (optional)")
        file = self._file_button("Choose guide", guide_files(), self.guide_path.setText)
        self._add("&Guide", self.guide_path, "guide", file)
        kinds = combo({None: "a value that rises or falls with depth", **GIVES})
        self.guide_gives = self._add("&What it gives", kinds, "guide_gives")
        for choice in (self.encoding, self.camera, self.guide_gives):  # no wider than the pictures
            choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            choice.setMinimumContentsLength(len(_NUMBERS))

    def _add(self, text: str, field: Field, option: str, *beside: QWidget) -> Field:
        """Add a field, with what is said of its reading option: files above the pictures, others below them."""
        if option:
            told = OPTIONS[option].help
            field.setToolTip(f"{told[:1].upper()}{told[1:]}.")
        field.setAccessibleName(text.replace("&", ""))
        changed = field.textChanged if isinstance(field, QLineEdit) else field.currentTextChanged
        changed.connect(self._schedule)
        line = QWidget()
        texts = tuple(part for part in (field, *beside) if isinstance(part, QLineEdit))
        lay_out(QHBoxLayout(line), field, *beside, stretched=texts, spacing=8)
        fields = self._form if field in (self.path, self.depth_path) else self._reading_form
        fields.addRow(label_of(text, field), line)
        self._rows[field] = fields, line
        return field

    def _show_row(self, field: QWidget, on: bool) -> None:
        fields, line = self._rows[field]
        fields.setRowVisible(line, on)

    def _button(self, text: str, choose: Callable[[], str], take: Callable[[str], object]) -> QPushButton:
        """Return a button that asks for a path, and takes it."""

        def browse() -> None:
            if path := choose():
                take(path)

        button = QPushButton(text, autoDefault=False)
        button.clicked.connect(browse)
        return button

    def _file_button(self, title: str, filters: str, take: Callable[[str], object]) -> QPushButton:
        return self._button("File…", lambda: choose_file(self, title, _FOLDER_KEY, filters), take)

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
            If files are missing, the depth encoding is unknown, or the invalid value, the minimum confidence or
            the intrinsics are not numbers.
        """
        (colour, depth), kind = self._paths(), self.kind
        if kind is Kind.NOTHING or (kind is Kind.PAIR and not depth):
            raise InputError(_NOTHING_SELECTED)
        units, name = self._encoding()
        options = ReadingOptions(
            encoding=name,
            depth_units=units,
            dataset=(self.dataset.text().strip() or None) if kind in (Kind.FRAME, Kind.FRAMES) else None,
            invalid=_number(self.invalid, "The invalid value must be a number of the depth file, such as 65535"),
            min_confidence=_number(
                self.min_confidence, "The minimum confidence must be a number of the confidence map, such as 2"
            ),
            intrinsics=self._intrinsics(),
            undistort=(self.undistort.isChecked() and self._states_lens(kind)) or None,
            view=_VIEWS[self.view.currentText()],
            guide=self.guide_path.text().strip() or None if kind in (Kind.PAIR, Kind.FRAME) else None,
            guide_gives=self.guide_gives.currentData() if kind in (Kind.PAIR, Kind.FRAME) else None,
        )
        return FrameRef(colour, depth if kind is Kind.PAIR else None, options=options)

    def read(self) -> None:
        """Read the chosen files and describe them."""
        self._reading_delay.stop()
        self._looks.forget()
        self._propose_partner()
        (colour, depth), kind = self._paths(), self.kind
        self._offer_options(kind)
        try:
            if kind is Kind.NOTHING:
                self._refuse(_NOTHING_SELECTED, "muted")
            elif kind in (Kind.PROJECT, Kind.RUN):
                self._describe_file(Path(colour), kind)
            elif kind is Kind.PAIR and not depth:
                read_colour(colour)  # reports an error of this file before asking for the other one
                self._refuse(_NO_DEPTH, "muted")
            elif kind is Kind.FRAMES:
                self._look_into(self.request())
            else:
                source = self.request()
                frame = read_frame(source)
                text = " ".join(filter(None, (_describe_frame(frame), described_beside(source))))
                self._show(frame, text, read_depth(source).plausibility_warnings if frame.notes else ())
        except NotAllowed as error:
            self._announce_question(error)
        except IlfError as error:
            self._refuse(str(error), "error")

    def _describe_file(self, path: Path, kind: Kind) -> None:
        """Describe a project or the record of a run."""
        if kind is Kind.RUN:
            record = read_record(path / RECORD_FILE if path.is_dir() else path)
            text = f"A run of {record.name} with {counted(len(record.blocks_outcome), 'block')}: the frame that was "
            text += "completed is opened, with blocks, parameters and result."
        else:
            with open_project(path) as opened:
                names = [frame.name for frame in opened.project.frames]
            shown = ", ".join(names[:_MAX_NAMED]) + ", …" * (len(names) > _MAX_NAMED)
            text = f"A project with {counted(len(names), 'frame')}: {shown}.\nIt takes the place of the present one."
        self._offer_unseen(text, "good")

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
        self._show_row(self.depth_path, is_pair)
        self._show_row(self.dataset, of_images and not is_pair)  # a pair names the dataset behind its depth
        self._show_row(self.guide_path, kind in (Kind.PAIR, Kind.FRAME))
        self._show_row(self.guide_gives, kind in (Kind.PAIR, Kind.FRAME))
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

    def _show(self, frame: RGBDFrame, text: str, plausibility_warnings: Iterable[PlausibilityWarning]) -> None:
        self.colour_preview.show_rgb(frame.rgb)
        self.depth_preview.show_depth(frame.depth)
        tone = "warning" if frame.notes else "text" if frame.intrinsics is None else "good"
        self._tell("\n".join((text, *frame.notes)), tone)
        self._propose(plausibility_warnings)
        self.open_button.setEnabled(True)

    def _look_into(self, source: FrameRef) -> None:
        """List the frames in a worker thread; meanwhile the source can be opened already."""
        self._offer_unseen("Listing frames…", "text")
        self._looks.ask(partial(preview_folder, source), self._show_first, self._refuse_source, key=source)

    def _show_first(self, look: FolderPreview) -> None:
        count, is_of_results = len(look.listing.sources), is_result_folder(look.listing.sources[0])
        frames = f"{counted(count, 'result' if is_of_results else 'frame')} found."
        text = " ".join((frames, *look.listing.notes))
        if look.frame is None:
            self._tell(f"{text}\nThe first frame cannot be read: {look.problem}", "warning")
        else:
            self._show(look.frame, f"{text} First frame:\n{_describe_frame(look.frame)}", look.plausibility_warnings)

    def _refuse_source(self, error: Exception) -> None:
        if isinstance(error, NotAllowed):
            self._announce_question(error)
        else:
            self._refuse(error_text(error), "error")

    def _announce_question(self, error: NotAllowed) -> None:
        """Say what a file names elsewhere; the window asks about it after *Open*."""
        places = " and ".join(error.places)
        text = f"A file names {places} outside its own folder, which was never opened here: Open asks first."
        self._offer_unseen(text, "warning")

    def _offer_unseen(self, text: str, tone: str) -> None:
        """Let the user open what is not read here."""
        self.colour_preview.show_rgb(None)
        self.depth_preview.show_depth(None)
        self._propose(())
        self._tell(text, tone)
        self.open_button.setEnabled(True)

    def _tell(self, text: str, tone: str) -> None:
        """Show a message, for which the dialog grows if it must."""
        self.message.show_message(text, tone)
        if (layout := self.layout()) is not None:
            self.resize(self.width(), max(self.height(), layout.totalHeightForWidth(self.width())))

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
        self.more.setChecked(True)  # to see what was set
        self.read()

    def _schedule(self) -> None:
        self.open_button.setEnabled(False)
        self._reading_delay.start()

    def _change_camera(self) -> None:
        choice = self.camera.currentText()
        self.camera_text.setVisible(choice in (_NUMBERS, _FILE))
        self.camera_browse.setVisible(choice == _FILE)
        self.undistort.setVisible(self._states_lens(self.kind))
        self.camera_text.setPlaceholderText(
            "fx, fy, cx, cy [px]: 525, 525, 319.5, 239.5"
            if choice == _NUMBERS
            else "JSON, YAML or text; FILE#NAME for one of several"
        )

    def _states_lens(self, kind: Kind) -> bool:
        """Whether the distortion of the lens can be stated, in a file of intrinsics or in those of a data set."""
        choice = self.camera.currentText()
        return choice == _FILE or (choice == _AS_STATED and kind is Kind.FRAMES)

    def _take_path(self, path: str) -> None:
        self._set_paths(path, "")

    def _set_paths(self, path: str, depth: str) -> None:
        self._write_paths(path, depth)
        self.read()

    def _write_paths(self, path: str, depth: str) -> None:
        with QSignalBlocker(self.path), QSignalBlocker(self.depth_path):
            if path != self.path.text():
                self.path.setText(path)
            self.depth_path.setText(depth)

    def _paths(self) -> tuple[str, str]:
        return self.path.text().strip(), self.depth_path.text().strip()

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
        if choice == _AS_STATED:
            return None
        if choice == _FILE:
            if not text:
                raise InputError("Choose the file with the intrinsics.")
            return str(Path(self._paths()[0]).parent / text)  # messages leave out the folder
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
        self._tell(text, tone)
        self._propose(
            _try_read(lambda: read_depth(self.request()).plausibility_warnings) or () if tone == "error" else ()
        )
        if colour and Path(colour).is_dir():
            found = _try_read(lambda: frame_folder(colour))
            colour, depth = (str(found.rgb), str(found.depth)) if found else ("", "")
        self.colour_preview.show_rgb(_try_read(lambda: read_colour(colour)) if colour else None)
        depth, dataset = split_dataset(depth)
        self.depth_preview.show_depth(_try_read(lambda: read_depth_values(depth, dataset=dataset)) if depth else None)


def _describe_frame(frame: RGBDFrame) -> str:
    """Describe a frame: depth, size and encoding in the first line, then guide and intrinsics."""
    known = frame.depth[frame.known]
    height, width = frame.shape
    encoding = "" if frame.inputs is None else encoding_of_inputs(frame.inputs).text
    first = (
        f"Median {np.median(known):.2f} m, range {known.min():.2f}–{known.max():.2f} m, {width} x {height}, "
        f"{100 * frame.missing_share:.0f} % missing{_outside(frame)}, {encoding}."
    )
    if frame.brought is not None:
        seen = 100 * frame.brought.seen.mean()
        first += f"\nIn the depth camera's view: colour was brought into it, and sees {seen:.0f} % of the pixels."
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

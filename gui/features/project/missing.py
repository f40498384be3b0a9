"""Frames that cannot be opened since their files are missing or have changed, or since the work on them is damaged."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QMessageBox

from ilf.data.frame import InputFile
from ilf.errors import InputError
from ilf.project.sources import MissingSource, located, moved
from ilf.project.state_codec import UnreadableFrame
from ilf.sources.named_places import note_opened
from ilf.sources.naming import META_NAME

from ...project.current_project import source_of
from ...state.workspace import Entry
from ...widgets.notices import ACCEPT, ask, error_text
from ...work.steps import Steps, in_steps
from ..context import Context

_FOLDER, _FILE, _AS_NEW = "Locate f&older…", "Locate &file…", "Open &anew"
_LOCATE = (
    "Locate the folder where its files are now, or a file that has another name: the others are looked for beside it. "
    "Only files with the original content are taken."
)
_ANEW = "Opened anew, its files are a new frame without the work, which stays in the project as it is."
_NOT_THERE = "No file with the original content is there. Choose another folder."


@in_steps
def ask_how_to_open(context: Context, entry: Entry, error: Exception) -> Steps[None]:
    """Ask where the files of a frame are that could not be opened, or offer to open them as a new frame."""
    answers: list[tuple[str, QMessageBox.ButtonRole]] = []
    remedies: list[str] = []
    title, source, missing = f"Open {entry.name}", source_of(entry), isinstance(error, MissingSource)
    if missing:
        title = f"Missing files of {context.recorder.present.name or entry.name}"
        answers += [(_FOLDER, ACCEPT), (_FILE, ACCEPT)]
        remedies.append(_LOCATE)
    if source is not None and (isinstance(error, UnreadableFrame) or getattr(error, "found", None) is not None):
        answers.append((_AS_NEW, ACCEPT))
        remedies.append(_ANEW)
    problem = error_text(error)
    while answers and problem:
        text = f"{entry.name} cannot be opened. {problem}"
        answer = yield partial(ask, context.window, title, text, " ".join(remedies), answers)
        problem = ""
        if answer == _AS_NEW and source is not None:
            context.loader.open_new(source, f"{entry.name} (anew)")
        elif answer and isinstance(error, MissingSource):
            problem = yield from _found(context, entry, error.wanted, answer == _FOLDER)
        elif context.workspace.shown is None:
            context.panels.reveal("Frames")


def _found(context: Context, entry: Entry, wanted: InputFile, in_folder: bool) -> Steps[str]:
    """Look for a frame's file where the user says that it is, and open the frame; others are opened with files there,
    too. Return why the place that is given does not help; "" if it does, or none is given."""
    store = context.recorder.store
    start = str(next((one for one in Path(wanted.path).parents if one.is_dir()), Path.home()))
    if in_folder:
        chosen = QFileDialog.getExistingDirectory(context.window, "Locate folder of the files", start)
    else:
        chosen = QFileDialog.getOpenFileName(context.window, f"Locate {Path(wanted.path).name}", start)[0]
    if not chosen:
        return ""
    place = Path(chosen)
    folders = dict.fromkeys((place, place.parent, *store.places.folders))
    given = {wanted.path: place} if place.is_file() else {}
    places = replace(store.places, given={**store.places.given, **given}, folders=tuple(folders))
    path, _ = yield partial(context.loader.read, f"Looking for {wanted.path}", lambda: located(wanted, places))
    if context.workspace.entries.of(entry.id) is not entry:  # another project was opened meanwhile
        return ""
    if path is None and not wanted.sha256 and not Path(wanted.path).suffix and (place / META_NAME).is_file():
        path = place  # the frame's folder itself, which has another name now
    if path is None:
        return _NOT_THERE
    note_opened(path)
    given = {wanted.path: path}
    if path.name == Path(wanted.path).name:
        given[str(Path(wanted.path).parent)] = path.parent
    store.places = replace(places, given={**places.given, **given})
    for one in context.workspace.entries:
        if one.source is not None:
            with suppress(InputError):  # its files are asked for when it is opened
                one.source = moved(one.source, store.places)
    context.recorder.present.found_elsewhere = True
    context.recorder.note_project()
    context.loader.open_entry(entry)
    return ""

"""Frames that cannot be opened since their files are missing or have changed, or since the work on them is damaged."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QFileDialog

from ilf.errors import InputError
from ilf.project.sources import MissingSource, located, moved
from ilf.project.state_codec import UnreadableFrame
from ilf.sources.named_places import note_opened

from ...project.current_project import source_of
from ...state.entries import Entry
from ...widgets.notices import ACCEPT, Answer, ask, error_text
from ..context import Context

_LOCATE = (
    "Locate the folder where its files are now, or a file that has another name: the others are looked for beside it. "
    "Only files with the original content are taken."
)
_ANEW = "Opened anew, its files are a new frame without the work, which stays in the project as it is."
_NOT_THERE = "No file with the original content is there. Choose another folder."


def ask_how_to_open(context: Context, entry: Entry, error: Exception, problem: str = "") -> None:
    """Ask where the files of a frame are that could not be opened, or offer to open them as a new frame.

    `problem` is why the place that was given before does not help; "" for none.
    """
    answers: list[Answer] = []
    remedies: list[str] = []
    if isinstance(error, MissingSource):
        window, wanted = context.window, Path(error.wanted.path)
        start, look = str(_nearest(wanted)), partial(_look, context, entry, error)

        def ask_folder() -> None:
            look(QFileDialog.getExistingDirectory(window, "Locate Folder of the Files", start))

        def ask_file() -> None:
            look(QFileDialog.getOpenFileName(window, f"Locate {wanted.name}", start)[0])

        answers += [("Locate f&older…", ACCEPT, ask_folder), ("Locate &file…", ACCEPT, ask_file)]
        remedies.append(_LOCATE)
    source = source_of(entry)
    if source is not None and (isinstance(error, UnreadableFrame) or getattr(error, "found", None) is not None):
        anew = partial(context.loader.open_new, source, f"{entry.name} (anew)")
        answers.append(("Open &anew", ACCEPT, anew))
        remedies.append(_ANEW)
    if not answers:
        return
    project = context.recorder.present.name
    title = f"Missing Files of {project or entry.name}" if isinstance(error, MissingSource) else f"Open {entry.name}"
    text = f"{entry.name} cannot be opened. {problem or error_text(error)}"

    def show_others() -> None:
        if not context.workspace.has_current:
            context.panels.reveal("Frames")

    ask(context.window, title, text, " ".join(remedies), answers, otherwise=show_others)


def _nearest(path: Path) -> Path:
    """Return the folder of a path, or its closest existing parent."""
    return next((one for one in path.parents if one.is_dir()), Path.home())


def _look(context: Context, entry: Entry, error: MissingSource, chosen: str) -> None:
    """Look for a frame's file at a path or in a folder that the user has chosen, if any, and open the frame; others are
    opened with files there, too."""
    if not chosen:
        return
    wanted, store, place = error.wanted, context.recorder.store, Path(chosen)
    folders = dict.fromkeys((place, place.parent, *store.places.folders))
    given = {wanted.path: place} if place.is_file() else {}
    places = replace(store.places, given={**store.places.given, **given}, folders=tuple(folders))

    def take(found: tuple[Path | None, Path | None]) -> None:
        path, _ = found
        if context.workspace.entries.of(entry.id) is not entry:  # another project was opened meanwhile
            return
        if path is None:
            ask_how_to_open(context, entry, error, _NOT_THERE)
            return
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

    context.loader.read(f"Looking for {wanted.path}", lambda: located(wanted, places), take)

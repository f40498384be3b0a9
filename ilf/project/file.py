"""Opening and saving project files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from ..errors import ExportError, IlfError, InputError
from .archive import Archive, Part, write_archive
from .decoding import Decoded, load_state
from .frame_state import FrameState
from .parts import Parts
from .project import Project, ProjectFrame
from .project_json import ReadProject, decode_project, read_only_reason
from .recorded import bare_state
from .saving import Saving
from .sources import Places

SUFFIX = ".ilf"


@dataclass(frozen=True)
class OpenedProject:
    """A project file that is open.

    Attributes
    ----------
    parts : Archive
    read : ReadProject
        What project.json says.
    """

    parts: Archive
    read: ReadProject

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def path(self) -> Path:
        """Of the project file, absolute."""
        return self.parts.path

    @property
    def project(self) -> Project:
        """The frames, and what is set for all of them."""
        return self.read.project

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be read of file and list, and what that means; a sentence each."""
        return self.parts.problems + self.read.problems

    @property
    def read_only(self) -> str:
        """Why it cannot be saved in its place; "" if it can."""
        return self.read.read_only

    @property
    def places(self) -> Places:
        """Where the files of its frames are."""
        return self.read.places

    def frame(self, frame_id: str) -> ProjectFrame:
        """A frame of the list; raises InputError if there is none."""
        for frame in self.project.frames:
            if frame.id == frame_id:
                return frame
        raise InputError(f"The project has no frame {frame_id:.40}.")

    def state(self, frame_id: str, places: Places | None = None) -> Decoded:
        """A frame with all work on it; of one without any, as its files have it.

        Parameters
        ----------
        frame_id : str
        places : Places, optional
            Where its files may be, in place of `self.places`.

        Raises
        ------
        MissingSource, ChangedSource
            If one of the frame's files is nowhere to be found, or has changed.
        InputError
            If there is no such frame, or it cannot be read.
        """
        frame = self.frame(frame_id)
        if not frame.has_state and frame.source is not None:
            return Decoded(bare_state(frame_id, frame.source.load()))
        return load_state(frame_id, self.parts, frame.source, places or self.places)

    def close(self) -> None:
        """Let go of the file."""
        self.parts.close()


def open_project(path: str | os.PathLike[str]) -> OpenedProject:
    """Open a project file; only its list of frames is read.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is no project file.
    """
    archive = Archive(path)
    try:
        return OpenedProject(archive, decode_project(archive, archive.path))
    except BaseException:
        archive.close()
        raise


def save_project(
    path: str | os.PathLike[str],
    project: Project,
    states: Sequence[FrameState] = (),
    *,
    base: Sequence[Parts] = (),
    frames: Mapping[str, Parts] | None = None,
    places: Places | None = None,
    embed: bool | None = None,
    on_part: Callable[[int, int], None] | None = None,
) -> tuple[str, ...]:
    """Write a project file: as a whole, or what is there stays as it is.

    What has not changed is copied as it is kept; what no frame refers to any more is left out.

    Parameters
    ----------
    path : path-like
    project : Project
    states : sequence of FrameState
        Of frames that have changed and are in no parts yet.
    base : sequence of Parts
        Where the other states, arrays, pictures and embedded files are: the first that has a part gives it. An
        `Archive` of the file that is saved is closed and read anew when it is replaced; it belongs here, too, if others
        read it for their own parts.
    frames : mapping of str to Parts, optional
        Id of a frame -> where its state is, before `base`.
    places : Places, optional
        Where the files of frames are now.
    embed : bool, optional
        Whether the very bytes of frames' files go into the project, so that it can be opened anywhere. None leaves
        those in that are in; False takes those out that are on this machine, too.
    on_part : callable, optional
        Called with the number of parts that have been written, and of all; what it raises ends it.

    Returns
    -------
    tuple of str
        What could not be saved as asked for, a sentence each.

    Raises
    ------
    ExportError
        If the file cannot be written, or the one that is there is write-protected or of a newer version.

    Examples
    --------
    >>> import ilf, numpy as np
    >>> frame = ilf.RGBDFrame(np.zeros((4, 6, 3), np.uint8), np.full((4, 6), 2.0), name="wall")
    >>> state = FrameState("a1", frame, np.ones((4, 6), np.int32), note="Flat.")
    >>> save_project("wall.ilf", Project((ProjectFrame("a1", "wall", None),)), [state])
    ()
    >>> with open_project("wall.ilf") as opened:
    ...     again = opened.state("a1").state
    >>> again.note, again.frame.name, int(again.labels.sum())
    ('Flat.', 'wall', 24)
    """
    _check_replaceable(path)
    saving = Saving(Path(path).absolute(), project, base, frames or {}, places or Places(), embed)
    names = saving.gather(states)
    total = len(names)

    def parts() -> Iterator[Part]:
        for done, name in enumerate(names):
            if on_part is not None:
                on_part(done, total)
            part = saving.part(name)
            if part is not None:
                yield part

    write_archive(path, parts(), [parts for parts in saving.stores if isinstance(parts, Archive)])
    return tuple(dict.fromkeys(saving.notes))


def _check_replaceable(path: str | os.PathLike[str]) -> None:
    """Raise ExportError if what is there is write-protected, or a project of a newer version."""
    if not Path(path).is_file():
        return
    if not os.access(path, os.W_OK):
        raise ExportError(f"{path} is write-protected. Save under another name.")
    try:
        with Archive(path) as there:
            reason = read_only_reason(there)
    except IlfError:
        return
    if reason:
        raise ExportError(f"{path} is not replaced. {reason}")

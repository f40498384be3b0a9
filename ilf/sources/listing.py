"""Listing the frames of a folder or a recording by file names and indices; no image is decoded."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from .._runtime.addresses import Address
from .._runtime.files import is_address, open_file
from .._runtime.formatting import counted
from .._runtime.named_places import note_opened
from ..errors import InputError, ParameterError, cause
from ..io.cameras import CAMERA_FILE
from ..io.kinds import kind_at
from .data_sets import bop_frames, has_time_lists, is_bop, is_sun, sun_frame, timed_frames
from .file_patterns import Folders, is_folder
from .frame_folder import is_frame_folder
from .frame_ref import FrameRef
from .layout import Layout
from .layout_frames import LayoutFrames
from .layouts import all_layouts, fitting, given_layouts, nearest_layout, scenes
from .naming import META_NAME
from .opening import forget, is_recording, opened, recording_suffixes
from .own_results import is_result
from .pairing import natural, paired, paired_by_time, split_by_kind, time_of, why_unpaired
from .plugins import source_plugins
from .reading_options import AS_STATED, ReadingOptions
from .recording import Topics
from .remote import address_of, names_at, restored
from .times import MAX_TIME_GAP_S

_MOST_NAMES = 5
"""Maximum number of folders that a note names."""

_COLOUR_FOLDERS = ("rgb", "color", "colour", "image", "images")
_DEPTH_FOLDERS = ("depth", "depths")

SUPPORTED_FOLDER_LAYOUTS = (
    f"A folder of frames contains one of these: a folder for each frame, with {META_NAME} and its images, or with "
    "rgb.png and depth.png; a folder rgb (or color, colour, image) and a folder depth, with files of the same names or "
    "numbers; colour and depth files side by side, such as 0001_rgb.png and 0001_depth.png; rgb.txt and depth.txt, "
    "which list files by time; scenes of BOP, frames of SUN RGB-D or raw files of NYU Depth; a layout of the table "
    "(`ilf info --layouts`), or one that you give (--layout)."
)


@dataclass(frozen=True)
class Listing:
    """Frames of a folder.

    Attributes
    ----------
    sources : tuple of FrameRef
        With absolute paths; in natural order of their names, or in order of time where that is known.
    notes : tuple of str
        Notes for the user, a sentence each.
    times : tuple of float
        Times of the frames' colour [s]; empty if not known.
    is_registered : bool
        Whether colour and depth have the same pixels. Where they do not, recordings are registered, and so are files
        whose depth intrinsics are known; others are read as they are, with the intrinsics of depth.
    layout : str
        What the folder was recognised as.
    """

    sources: tuple[FrameRef, ...]
    notes: tuple[str, ...] = ()
    times: tuple[float, ...] = ()
    is_registered: bool = True
    layout: str = ""


def list_frames(
    folder: str | os.PathLike[str],
    given: ReadingOptions = AS_STATED,
    *,
    max_gap: float = MAX_TIME_GAP_S,
    topics: Topics | None = None,
    layout: str | os.PathLike[str] | None = None,
) -> Listing:
    """List the frames of a folder or a recording.

    A folder may contain a folder for each frame; a folder of colour and one of depth, matched by names or numbers, or
    by time where names are times; colour and depth files side by side; or lists of both by time, whose depth has 5000
    units per metre by default. Scenes of BOP, frames of SUN RGB-D, and folders that a layout of the table fits
    (`ilf.sources.layouts`) are read with the options of these data sets. A frame folder is listed as a single frame.
    Recordings (see `ilf.open_source`) contain their frames, which are not decoded.

    Parameters
    ----------
    folder : path-like
        A path, or an address.
    given : ReadingOptions
        They replace the options of each frame; those for a single frame are not used.
    max_gap : float
        Maximum time difference [s] of colour and depth of one frame, where they are matched by time.
    topics : tuple of str, optional
        Topics of colour and depth, in a ROS recording with several cameras. None selects the most suitable ones.
    layout : str or path-like, optional
        The layout of the folder, as `given_layouts` takes it. None recognises it.

    Raises
    ------
    InputError
        If there is no such folder, it cannot be read, it contains no frames, or its depth would be misread.
    FormatError
        If its lists by time, its calibrations or the layout are damaged.
    ParameterError
        If both units and an encoding are given, the minimum confidence is not a number, `max_gap` is not a duration, or
        `topics` are given for a source without topics.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> [Path(source.rgb).name for source in list_frames(asset_path("samples")).sources]
    ['room']
    """
    given = given.of_all_frames.checked()
    if not max_gap >= 0:
        raise ParameterError(f"The maximum time gap must be 0 s or more, not {max_gap!r:.60}.")
    if is_address(folder):
        found = _at_address(Address(folder), given, max_gap, topics, layout)
    else:
        found = _listed(Path(folder).absolute(), given, max_gap, topics, layout)
    note_opened(folder, *given.camera_paths.values())
    return found


def _listed(
    root: Path,
    given: ReadingOptions,
    max_gap: float,
    topics: Topics | None,
    layout: str | os.PathLike[str] | None,
) -> Listing:
    """The frames of a folder or a recording on this machine."""
    if layout is not None:
        return _by_given_layout(root, given, given_layouts(layout))
    if is_recording(root):
        return _recorded(root, given, max_gap, topics)
    if topics is not None:
        raise ParameterError(f"{root} is not a ROS recording: it has no topics. Leave the topics out.")
    found = _of_folder(root, given, max_gap)
    return replace(found, notes=(*found.notes, *source_plugins().notes))


def _of_folder(root: Path, given: ReadingOptions, max_gap: float) -> Listing:
    """The frames of a folder that is no recording, by what is in it."""
    content = _content(root)
    if META_NAME in content.files:
        return Listing((FrameRef(str(root), options=given),), layout=f"a frame folder with {META_NAME}")
    if has_time_lists(content.files):
        sources, times, notes = timed_frames(root, content.files, given, max_gap)
        return Listing(tuple(sources), notes, times, layout="lists of files by time, as in the TUM benchmark")
    if is_bop(content.files):
        return _of_scenes(root, [str(root)], given)
    if is_sun(content.files, content.folders):
        return Listing((sun_frame(root, given),), layout="frames of SUN RGB-D")
    folders = Folders(str(root))
    if found := _by_layout(folders, given, fitting(folders, all_layouts(), [""])):
        return found
    pairs, notes, why_none = _side_by_side(root, content, max_gap)
    sources, what = [_of_pair(rgb, depth, given, pairs) for rgb, depth in pairs], "colour and depth files in pairs"
    if not sources:
        inside = [os.path.join(root, name) for name in sorted(content.folders, key=natural)]
        if paths := [path for path in inside if os.path.isfile(os.path.join(path, CAMERA_FILE))]:
            return _of_scenes(root, paths, given)
        if found := _by_layout(folders, given, fitting(folders, all_layouts(), scenes(folders))):
            return found
        frames = [_frame_in(path, given) for path in inside]
        sources, what = [source for frame in frames for source in frame], "a folder for each frame"
        if empty := [os.path.basename(path) for path, frame in zip(inside, frames, strict=True) if not frame]:
            notes.append(
                f"{counted(len(empty), 'folder')} left out: there is no matching colour and depth file, or more than "
                f"one ({_first_names(empty)})."
            )
    if not sources:
        told = f"{root} contains no frames: {why_none}"
        if not why_none:
            told = f"{root} contains no frames. {nearest_layout(folders)} {SUPPORTED_FOLDER_LAYOUTS}"
        raise InputError(source_plugins().with_notes(told))
    sources, left_out = _without_results(sources)
    return Listing(tuple(sources), (*notes, *left_out), _times(sources), layout=what)


def _without_results(sources: list[FrameRef]) -> tuple[list[FrameRef], tuple[str, ...]]:
    """The frames without folders that this program wrote, and a note that names these; all if there are no others."""
    results = [source for source in sources if source.depth is None and is_result(source)]
    if not results or len(results) == len(sources):
        return sources, ()
    names = _first_names([source.name for source in results])
    note = f"{counted(len(results), 'folder')} left out: the depth was completed by ILF Studio, not measured ({names})."
    return [source for source in sources if source not in results], (note,)


def _first_names(names: Sequence[str]) -> str:
    """The first names of folders, for a note."""
    return ", ".join(names[:_MOST_NAMES]) + (", ..." if len(names) > _MOST_NAMES else "")


def _at_address(
    address: Address,
    given: ReadingOptions,
    max_gap: float,
    topics: Topics | None,
    layout: str | os.PathLike[str] | None,
) -> Listing:
    """The frames at an address, as on a disk."""
    forget(address)
    if layout is None and is_recording(address):
        found = _recorded(address, given, max_gap, topics)
    else:
        with names_at(address) as root:
            if layout is None and is_recording(root):
                found = _recorded(address, given, max_gap, topics)
            else:
                found = _listed(root, given, max_gap, topics, layout)
                found = replace(found, sources=tuple(_at(address, source) for source in found.sources))
    return replace(found, notes=tuple(map(restored, found.notes)))


def _at(address: Address, source: FrameRef) -> FrameRef:
    """A frame that was listed below copies of the names at an address."""
    stated_in = None if source.stated_in is None else str(address)
    return replace(source.with_paths(address_of), stated_in=stated_in)


def _times(sources: Sequence[FrameRef]) -> tuple[float, ...]:
    """The times in the names of the frames' colour files; empty if they are not times."""
    times = tuple(time for source in sources if (time := time_of(source.rgb)) is not None)
    return times if len(times) == len(sources) else ()


def _by_layout(
    folders: Folders, given: ReadingOptions, layouts: Iterable[Layout], *, is_given: bool = False
) -> Listing | None:
    """The frames by the first of these layouts that has any; the others that have some are named in a note, and so are
    missing files of a layout that the user gave."""
    found: Listing | None = None
    others = []
    for layout in layouts:
        listed = LayoutFrames(layout, folders)
        if found is not None:
            others += [layout.text] if listed.has_frames else []
        elif sources := listed.sources(given):
            notes = [*([layout.note] if layout.note else []), *listed.unmatched.notes("of that name")]
            if is_given and listed.not_found:
                notes.append(f"There is no file {' and no '.join(listed.not_found)}: frames are read without.")
            is_registered = layout.registered and not layout.depth_K
            found = Listing(tuple(sources), tuple(notes), _times(sources), is_registered, layout.text)
    if found is None or not others:
        return found
    return replace(
        found, notes=(*found.notes, f"Read by the layout {found.layout}. Other layouts fit, too: {', '.join(others)}.")
    )


def _by_given_layout(root: Path, given: ReadingOptions, layouts: Sequence[Layout]) -> Listing:
    _content(root)  # reports a path that is no folder
    folders = Folders(str(root))
    if found := _by_layout(folders, given, layouts, is_given=True):
        return found
    fits = next(fitting(folders, all_layouts(), scenes(folders)), None)
    hint = nearest_layout(folders) if fits is None else f"It fits the layout {fits.text}: leave --layout out."
    told = "; ".join(f"{layout.text}: {LayoutFrames(layout, folders).counts}" for layout in layouts)
    raise InputError(f"{root} contains no frames of the given layout. {told}. {hint}".rstrip())


@dataclass(frozen=True)
class _Content:
    files: frozenset[str]
    folders: tuple[str, ...]

    def file(self, names: Iterable[str]) -> str | None:
        """The first of these files that exists."""
        return next((name for name in names if name in self.files), None)

    def folder(self, names: Iterable[str]) -> str | None:
        """The first of these folders that exists, ignoring case."""
        there = {name.lower(): name for name in self.folders}
        return next((there[name] for name in names if name in there), None)


def _content(folder: str | Path) -> _Content:
    """Names in a folder, without hidden ones."""
    try:
        with os.scandir(folder) as entries:
            shown = [(entry.name, is_folder(entry)) for entry in entries if not entry.name.startswith(".")]
    except NotADirectoryError:
        open_file(folder).close()  # a pipe or a device is named as such
        kind = kind_at(Path(folder)) or ("a file",)
        told = f"{folder} is {kind[0]}, but not a recording that is read ({', '.join(recording_suffixes())}). Give such"
        raise InputError(source_plugins().with_notes(f"{told} one, or the folder that contains the frames.")) from None
    except FileNotFoundError:
        raise InputError(f"{folder}: there is no such folder. Check the name.") from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"{folder!s:.200}: cannot be read ({cause(error)}). Check the name and its permissions."
        ) from error
    return _Content(
        frozenset(name for name, is_folder in shown if not is_folder),
        tuple(name for name, is_folder in shown if is_folder),
    )


def _recorded(path: Path | Address, given: ReadingOptions, max_gap: float, topics: Topics | None) -> Listing:
    """The frames of a recording."""
    with opened(path) as recording:
        if topics is not None and not recording.has_topics:
            raise ParameterError(f"{path} is {recording.kind}: it has no topics. Leave the topics out.")
        index = recording.index(max_gap, topics)
        registered, kind = recording.cameras(index.keys[0]).is_registered, recording.kind
    sources = tuple(FrameRef(str(path), frame=key, options=given) for key in index.keys)
    return Listing(sources, index.notes, index.times, registered, kind)


def _of_scenes(root: Path, scenes: list[str], given: ReadingOptions) -> Listing:
    """The frames of scenes of BOP."""
    found = [source for scene in scenes for source in bop_frames(scene, given)]
    if not found:
        raise InputError(f"{root}: none of its BOP scenes has both colour and depth of an image.")
    return Listing(tuple(found), layout="scenes of BOP")


def _side_by_side(root: Path, content: _Content, max_gap: float) -> tuple[list[tuple[str, str]], list[str], str]:
    """Pairs of paths in two folders or in one, and notes; or why there are none, as the rest of a sentence."""
    rgb, depth = content.folder(_COLOUR_FOLDERS), content.folder(_DEPTH_FOLDERS)
    if rgb is not None and depth is not None:
        at = os.path.join(root, rgb), os.path.join(root, depth)
        colours, depths = ([*_content(folder).files] for folder in at)
    else:
        at = str(root), str(root)
        colours, depths = split_by_kind(content.files)
    pairs, match_condition = paired(colours, depths), "of that name"
    if not (pairs.pairs or pairs.shared):
        pairs, match_condition = paired_by_time(colours, depths, max_gap), f"within {max_gap:g} s"
    if not pairs.pairs:
        is_meant = (colours and depths) or (at[0] != at[1] and (colours or depths))
        return [], [], why_unpaired(colours, depths, max_gap) if is_meant else ""
    if at[0] == at[1]:
        pairs = pairs._replace(unmatched_colours=0)  # they may be other images
    paths = [(os.path.join(at[0], one), os.path.join(at[1], other)) for one, other in pairs.pairs]
    return paths, pairs.notes(match_condition), ""


def _frame_in(folder: str, given: ReadingOptions) -> list[FrameRef]:
    """The frame of a folder: the folder itself if it has a meta.json, a frame of SUN RGB-D, or its only pair; empty if
    there is no pair, or more than one."""
    if os.path.isfile(os.path.join(folder, META_NAME)):
        return [FrameRef(folder, options=given)]
    try:
        content = _content(folder)
        if is_sun(content.files, content.folders):
            return [sun_frame(folder, given)]
    except InputError:
        return []
    pairs = paired(*split_by_kind(content.files)).pairs
    if len(pairs) != 1:
        return []
    return [_of_pair(os.path.join(folder, pairs[0][0]), os.path.join(folder, pairs[0][1]), given, pairs)]


def _of_pair(rgb: str, depth: str, given: ReadingOptions, pairs: Sequence[tuple[str, str]]) -> FrameRef:
    """The frame of a pair of files: their folder, if they are its only pair and it is a frame folder."""
    folder = os.path.dirname(rgb)
    if len(pairs) == 1 and folder == os.path.dirname(depth) and is_frame_folder(folder):
        return FrameRef(folder, options=given)
    return FrameRef(rgb, depth, options=given)

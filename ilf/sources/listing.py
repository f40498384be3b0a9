"""Listing the frames of a folder or a recording by file names and indices; no image is decoded."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from .._runtime.addresses import Address
from .._runtime.files import is_address, open_file
from .._runtime.formatting import counted, natural
from ..errors import InputError, ParameterError, cause
from ..io.cameras import frame_camera
from ..io.kinds import UNPACK, kind_at
from .copies import address_of, names_at, restored
from .data_sets import has_time_lists, is_sun, sun_frame, timed_frames
from .file_patterns import Folders
from .frame_folder import is_frame_folder
from .frame_ref import AS_STATED, FrameRef, ReadingOptions, is_result
from .layout import Layout
from .layout_frames import LayoutFrames
from .layouts import all_layouts, fitting, given_layouts, nearest_layout, scenes
from .named_places import note_opened
from .naming import META_NAME
from .opening import forget, is_recording, opened, recording_suffixes
from .pairing import left_out, paired, paired_by_time, split_by_kind, time_of, why_unpaired
from .plugins import source_plugins

_MOST_NAMES = 5
"""Maximum number of folders that a note names."""

_COLOUR_FOLDERS = ("rgb", "color", "colour", "image", "images")
_DEPTH_FOLDERS = ("depth", "depths")

SUPPORTED_FOLDER_LAYOUTS = (
    f"A folder of frames contains a folder for each frame, with {META_NAME} and images, or with rgb.png and depth.png; "
    "folders rgb and depth with files of the same names or numbers; files such as 0001_rgb.png and 0001_depth.png; "
    "rgb.txt and depth.txt, which list files by time; frames of SUN RGB-D or raw files of NYU Depth; or "
    "a layout of the table (`ilf info --layouts`), or one that you give (--layout)."
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


def list_frames(folder: str | os.PathLike[str], options: ReadingOptions = AS_STATED) -> Listing:
    """List the frames of a folder or a recording.

    A folder may contain a folder for each frame; a folder of colour and one of depth, matched by names or numbers, or
    by time where names are times; colour and depth files side by side; or lists of both by time, whose depth has 5000
    units per metre by default. Frames of SUN RGB-D, and folders that a layout of the table fits
    (`ilf.sources.layouts`) are read with the options of these data sets. A frame folder is listed as a single frame.
    Recordings (see `ilf.open_source`) contain their frames, which are not decoded.

    Parameters
    ----------
    folder : path-like
        A path, or an address.
    options : ReadingOptions
        How frames are found, and options that replace those of each frame; those for a single frame are not used.

    Raises
    ------
    InputError
        If there is no such folder, it cannot be read, it contains no frames, its depth would be misread, or there are
        no such intrinsics.
    FormatError
        If its lists by time, its calibrations or the layout are damaged.
    ParameterError
        As `ReadingOptions.checked`, and if topics are given for a source without topics.
    ExportError
        If a recording at an address cannot be copied to this machine.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> [Path(source.rgb).name for source in list_frames(asset_path("samples")).sources]
    ['room']
    """
    options = options.checked()
    for camera in (options.intrinsics, options.depth_intrinsics):
        if not is_address(camera):
            frame_camera(camera, None)
    found = _at_address(Address(folder), options) if is_address(folder) else _listed(Path(folder).absolute(), options)
    note_opened(folder, *options.camera_paths.values())
    return found


def _listed(root: Path, options: ReadingOptions) -> Listing:
    """The frames of a folder or a recording on this machine."""
    if options.layout is not None:
        return _by_given_layout(root, options.of_all_frames, given_layouts(options.layout))
    if is_recording(root):
        return _recorded(root, options)
    if options.topics is not None:
        raise ParameterError(f"{root} is not a ROS recording: it has no topics. Leave the topics out.")
    found = _of_folder(root, options.of_all_frames, options.time_gap)
    return replace(found, notes=(*found.notes, *source_plugins().notes))


def _at_address(address: Address, options: ReadingOptions) -> Listing:
    """The frames at an address, as on a disk."""
    forget(address)
    if options.layout is None and is_recording(address):
        found = _recorded(address, options)
    else:
        with names_at(address) as root:
            if options.layout is None and is_recording(root):
                found = _recorded(address, options)
            else:
                found = _listed(root, options)
                found = replace(found, sources=tuple(_at(address, source) for source in found.sources))
    return replace(found, notes=tuple(map(restored, found.notes)))


def _at(address: Address, source: FrameRef) -> FrameRef:
    """A frame that was listed below copies of the names at an address."""
    stated_in = None if source.stated_in is None else str(address)
    return replace(source.with_paths(address_of), stated_in=stated_in)


def _recorded(path: Path | Address, options: ReadingOptions) -> Listing:
    """The frames of a recording."""
    with opened(path) as recording:
        if options.topics is not None and not recording.has_topics:
            raise ParameterError(f"{path} is {recording.kind}: it has no topics. Leave the topics out.")
        keys, times, notes = recording.index(options.time_gap, options.topics)
        registered, kind = recording.cameras(keys[0]).is_registered, recording.kind
    sources = tuple(FrameRef(str(path), frame=key, options=options.of_all_frames) for key in keys)
    return Listing(sources, notes, times, registered, kind)


# Folders.


def _of_folder(root: Path, given: ReadingOptions, max_gap: float) -> Listing:
    """The frames of a folder that is no recording, by what is in it."""
    _check_folder(root)
    folders = Folders(str(root))
    files, inside = folders.content("")
    if META_NAME in files:
        return Listing((FrameRef(str(root), options=given),), layout=f"a frame folder with {META_NAME}")
    if has_time_lists(files):
        sources, times, notes = timed_frames(root, files, given, max_gap)
        return Listing(tuple(sources), notes, times, layout="lists of files by time, as in the TUM benchmark")
    if is_sun(files, inside) and len(folders.content("image")[0]) == 1:  # SUN3D has sequences of such names
        return Listing((sun_frame(root, given),), layout="frames of SUN RGB-D")
    if found := _by_layout(folders, given, fitting(folders, all_layouts(), [""])):
        return found
    pairs, pair_notes, why_none = _side_by_side(folders, max_gap)
    if pairs:
        refs = [_of_pair(rgb, depth, given, pairs) for rgb, depth in pairs]
        return _of_measured(refs, pair_notes, "colour and depth files in pairs")
    if found := _by_layout(folders, given, fitting(folders, all_layouts(), scenes(folders))):
        return found
    frames = {name: _frame_in(folders, name, given) for name in sorted(inside, key=natural)}
    if refs := [ref for ref in frames.values() if ref is not None]:
        empty = [name for name, ref in frames.items() if ref is None]
        why = f"there is no matching colour and depth file, or more than one ({_first_names(empty)})"
        empty_notes = [f"{counted(len(empty), 'folder')} left out: {why}."] if empty else []
        return _of_measured(refs, empty_notes, "a folder for each frame")
    told = f"{root} contains no frames: {why_none}"
    if not why_none:
        told = f"{root} contains no frames. {nearest_layout(folders)} {SUPPORTED_FOLDER_LAYOUTS}"
    raise InputError(source_plugins().with_notes(told))


def _of_measured(sources: list[FrameRef], notes: Sequence[str], layout: str) -> Listing:
    """A listing without folders that this program wrote, which a note names; of all if there are no others."""
    results = [source for source in sources if source.depth is None and is_result(source)]
    if results and len(results) < len(sources):
        names, count = _first_names([source.name for source in results]), counted(len(results), "folder")
        notes = *notes, f"{count} left out: the depth was completed by ILF Studio, not measured ({names})."
        sources = [source for source in sources if source not in results]
    return Listing(tuple(sources), tuple(notes), _times(sources), layout=layout)


def _first_names(names: Sequence[str]) -> str:
    """The first names of folders, for a note."""
    return ", ".join(names[:_MOST_NAMES]) + (", ..." if len(names) > _MOST_NAMES else "")


def _times(sources: Sequence[FrameRef]) -> tuple[float, ...]:
    """The times in the names of the frames' colour files; empty if they are not times."""
    times = tuple(time for source in sources if (time := time_of(source.rgb)) is not None)
    return times if len(times) == len(sources) else ()


def _check_folder(folder: Path) -> None:
    """Raise InputError for what is no folder, or cannot be read."""
    try:
        os.scandir(folder).close()
    except NotADirectoryError:
        open_file(folder).close()  # a pipe or a device is named as such
        kind, remedy = kind_at(folder) or ("a file", "")
        is_packed = "unpack it" in remedy.lower()
        remedy = UNPACK if is_packed else "Give such one, or the folder that contains the frames."
        told = f"{folder} is {kind}, but not a recording that is read ({', '.join(recording_suffixes())}). {remedy}"
        raise InputError(source_plugins().with_notes(told)) from None
    except FileNotFoundError:
        raise InputError(f"{folder}: there is no such folder. Check the name.") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{folder!s:.200}: cannot be read ({cause(error)}). Check its permissions.") from error


def _side_by_side(folders: Folders, max_gap: float) -> tuple[list[tuple[str, str]], list[str], str]:
    """Pairs of paths in two folders or in one, and notes; or why there are none, as the rest of a sentence."""
    files, inside = folders.content("")
    there = {name.lower(): name for name in inside}
    at = [next((there[name] for name in names if name in there), "") for names in (_COLOUR_FOLDERS, _DEPTH_FOLDERS)]
    if is_apart := all(at):
        for folder in at:
            _check_folder(Path(folders.root, folder))
        colours, depths = (folders.content(folder)[0] for folder in at)
    else:
        at = ["", ""]
        colours, depths = split_by_kind(files)
    pairs, match_condition = paired(colours, depths), "of that name"
    if not (pairs.pairs or pairs.shared):
        pairs, match_condition = paired_by_time(colours, depths, max_gap), f"within {max_gap:g} s"
    if not pairs.pairs:
        is_meant = (colours and depths) or (is_apart and (colours or depths))
        return [], [], why_unpaired(colours, depths, max_gap) if is_meant else ""
    if not is_apart:
        pairs = pairs._replace(unmatched_colours=0)  # they may be other images
    roots = [os.path.join(folders.root, folder) for folder in at]
    paths = [(os.path.join(roots[0], one), os.path.join(roots[1], other)) for one, other in pairs.pairs]
    return paths, pairs.notes(match_condition), ""


def _frame_in(folders: Folders, name: str, given: ReadingOptions) -> FrameRef | None:
    """The frame of a folder: the folder itself if it has a meta.json, a frame of SUN RGB-D, or its only pair; None if
    there is no pair, or more than one."""
    path, (files, inside) = os.path.join(folders.root, name), folders.content(name)
    if META_NAME in files:
        return FrameRef(path, options=given)
    try:
        if is_sun(files, inside):
            return sun_frame(path, given)
    except InputError:
        return None
    pairs = [(os.path.join(path, rgb), os.path.join(path, depth)) for rgb, depth in paired(*split_by_kind(files)).pairs]
    return _of_pair(*pairs[0], given, pairs) if len(pairs) == 1 else None


def _of_pair(rgb: str, depth: str, given: ReadingOptions, pairs: Sequence[tuple[str, str]]) -> FrameRef:
    """The frame of a pair of files: their folder, if they are its only pair and it is a frame folder."""
    folder = os.path.dirname(rgb)
    if len(pairs) == 1 and folder == os.path.dirname(depth) and is_frame_folder(folder):
        return FrameRef(folder, options=given)
    return FrameRef(rgb, depth, options=given)


# Layouts.


def _by_layout(
    folders: Folders, given: ReadingOptions, layouts: Iterable[Layout], *, is_given: bool = False
) -> Listing | None:
    """The frames by the first of these layouts that has any; the others that have some are named in a note, and so are
    missing files of a layout that the user gave."""
    tried = ((layout, LayoutFrames(layout, folders)) for layout in layouts)
    first = next(((layout, listed, refs) for layout, listed in tried if (refs := listed.sources(given))), None)
    if first is None:
        return None
    layout, listed, sources = first
    notes = [*([layout.note] if layout.note else []), *left_out(*listed.unmatched, "of that name")]
    if is_given and listed.not_found:
        notes.append(f"There is no file {' and no '.join(listed.not_found)}: frames are read without.")
    if others := ", ".join(other.text for other, listed in tried if listed.frames):
        notes.append(f"Read by the layout {layout.text}. Other layouts fit, too: {others}.")
    is_registered = layout.registered and layout.depth_K in {"", layout.K}
    return Listing(tuple(sources), tuple(notes), _times(sources), is_registered, layout.text)


def _by_given_layout(root: Path, given: ReadingOptions, layouts: Sequence[Layout]) -> Listing:
    _check_folder(root)
    folders = Folders(str(root))
    if found := _by_layout(folders, given, layouts, is_given=True):
        return found
    fits = next(fitting(folders, all_layouts(), scenes(folders)), None)
    hint = nearest_layout(folders) if fits is None else f"It fits the layout {fits.text}: leave --layout out."
    told = []
    for layout in layouts:
        counts = zip((layout.rgb, layout.depth), LayoutFrames(layout, folders).counts, strict=True)
        files = " and ".join(f"{pattern} matches {counted(count, 'file')}" for pattern, count in counts)
        told.append(f"{layout.text}: {files}, of which none belong together")
    raise InputError(f"{root} contains no frames of the given layout. {'; '.join(told)}. {hint}".rstrip())

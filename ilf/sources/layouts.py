"""The table of layouts, and finding those that fit a folder."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path

from .._runtime.installation import user_path
from ..errors import InputError
from .file_patterns import MAX_LEVELS, Folders, alternatives, files_like
from .layout import Layout, layout_from_text, layouts_from_file
from .plugins import source_plugins

_SUFFIX = ".toml"
_TABLE = "layouts.toml"
_MAX_SCENES = 300
"""Number of folders below the opened one in which a layout is looked for."""


def layouts_folder() -> Path:
    """Folder of the user's layouts, which may not exist; the environment variable ILF_LAYOUTS overrides it."""
    return user_path("data", "layouts", "ILF_LAYOUTS")


@cache
def built_in_layouts() -> tuple[Layout, ...]:
    """The layouts that come with the program."""
    with as_file(files(__package__) / _TABLE) as path:
        return tuple(layouts_from_file(path))


def all_layouts() -> tuple[Layout, ...]:
    """The user's layouts, by file name, then those of plugins and the built-in ones that have no such name.

    Raises
    ------
    FormatError
        If a file of the user's folder is not valid.
    """
    own = {one.name: one for path in sorted(layouts_folder().glob(f"*{_SUFFIX}")) for one in layouts_from_file(path)}
    others = (*source_plugins().layouts, *built_in_layouts())
    return *own.values(), *(one for one in others if one.name not in own)


def given_layouts(given: str | os.PathLike[str]) -> tuple[Layout, ...]:
    """The layouts that a user names.

    Parameters
    ----------
    given : str or path-like
        A text key=value ..., the name of a layout, or a TOML file, whose layouts are tried in order.

    Raises
    ------
    InputError
        If there is no such layout or file.
    FormatError
        If it is not valid.
    """
    text = os.fspath(given)
    if text.lower().endswith(_SUFFIX) and "=" not in text:
        return tuple(layouts_from_file(Path(text)))
    if "=" in text:
        return (layout_from_text(text),)
    known = all_layouts()
    found = tuple(one for one in known if one.name == text)
    if not found:
        names, such = ", ".join(one.name for one in known), '"rgb=color/*.jpg depth=depth/*.png units=1000"'
        raise InputError(f"There is no layout {text!r:.60}. Known: {names}. Or give a TOML file, or text: {such}.")
    return found


def scenes(folders: Folders) -> Iterator[str]:
    """The opened folder and folders below it: the first one of each level, then all, level by level, up to a limit."""
    first: str | None = ""
    for _ in range(MAX_LEVELS + 1):
        if first is not None:
            yield first
            first = next(iter(folders.inside(first)), None)
    level, left = folders.inside(""), _MAX_SCENES
    while level and left > 0:
        level = level[:left]
        yield from level
        left -= len(level)
        level = [inner for folder in level for inner in folders.inside(folder)]


def fitting(folders: Folders, layouts: Sequence[Layout], below: Sequence[str] | Iterator[str]) -> Iterator[Layout]:
    """The layouts that fit one of these folders, taken for {}; each once.

    Parameters
    ----------
    folders : Folders
        The opened folder.
    layouts : sequence of Layout
    below : iterable of str
        Folders relative to the opened one.
    """
    seen: set[str] = set()
    for folder in below:
        for layout in layouts:
            is_other = any(_is_there(folders, text, folder) for text in layout.excludes)
            if layout.name not in seen and not is_other and not _lacking(folders, layout, folder):
                seen.add(layout.name)
                yield layout


def _lacking(folders: Folders, layout: Layout, below: str) -> list[str]:
    """The patterns without which a folder does not fit a layout, and that nothing in it matches."""
    wanted = layout.rgb, layout.depth, *layout.needs
    return [text for text in wanted if not _is_there(folders, text, below)]


def _is_there(folders: Folders, text: str, below: str) -> bool:
    return any(next(files_like(one, folders, below), None) is not None for one in alternatives(text))


def nearest_layout(folders: Folders) -> str:
    """A sentence with the layout of which a folder has most, and what it lacks; "" if it has nothing of any."""
    best: tuple[int, str] = (0, "")
    for folder in scenes(folders):
        for layout in all_layouts():
            lacking = _lacking(folders, layout, folder)
            others = [text for text in (layout.truth, layout.confidence, layout.K, layout.pose) if text]
            there = [text for text in (layout.rgb, layout.depth, *layout.needs) if text not in lacking]
            there += [text for text in others if _is_there(folders, text, folder)]
            told = [text for text in there if not text.removeprefix("{}/").startswith("*.")]
            if len(told) > best[0] and lacking:
                finds = f"{' and '.join(there)}{f' in {folder}' if folder else ''}, but lacks {' and '.join(lacking)}"
                best = len(told), f"The nearest layout is {layout.text}: it finds {finds}."
    return best[1]

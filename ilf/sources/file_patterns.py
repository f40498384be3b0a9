"""Patterns of file paths with placeholders, and the files of a folder that match them."""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

from ..errors import ParameterError

ANY_FOLDERS = "{}"
MAX_LEVELS = 5
"""Maximum number of folders that {} stands for."""

_MAX_IN_A_NAME, _MAX_ALTERNATIVES = 4, 64
"""Maximum numbers of placeholders in a name and of alternatives of a pattern: more would take too long to match."""

File = tuple[str, dict[str, str]]
"""The path of a file relative to the opened folder, with /, and the text of each placeholder of its pattern."""

_ALTERNATIVES = re.compile(r"\{([^{}]*,[^{}]*)\}")
_PLACEHOLDER = re.compile(r"\{(\w*)\}", re.ASCII)


class Folders:
    """The contents of folders under a root, each read once. Hidden files and folders are left out."""

    def __init__(self, root: str) -> None:
        self.root = root
        self.content = cache(self._content)
        """Gives the names of the files and the folders in a folder, relative to the root, sorted; empty if there is
        none."""

    def _content(self, folder: str) -> tuple[list[str], list[str]]:
        files: list[str] = []
        folders: list[str] = []
        try:
            with os.scandir(os.path.join(self.root, folder)) as entries:
                for entry in entries:
                    if not entry.name.startswith("."):
                        (folders if is_folder(entry) else files).append(entry.name)
        except (OSError, ValueError):  # no such folder, or it cannot be read
            pass
        return sorted(files), sorted(folders)

    def inside(self, folder: str) -> list[str]:
        """The folders in a folder, relative to the root."""
        return [f"{folder}/{name}" if folder else name for name in self.content(folder)[1]]


def is_folder(entry: os.DirEntry[str]) -> bool:
    """Whether an entry is a folder; False for a link that leads nowhere, which must not prevent listing the others."""
    try:
        return entry.is_dir()
    except OSError:
        return False


def check_pattern(text: str) -> None:
    """Raise ParameterError for a pattern that is no relative path, or would take too long to match."""
    parts = _numbered(text).split("/")
    choices = math.prod(found[1].count(",") + 1 for found in _ALTERNATIVES.finditer(text))
    if choices > _MAX_ALTERNATIVES or any(len(_PLACEHOLDER.findall(part)) > _MAX_IN_A_NAME for part in parts):
        most = f"{_MAX_ALTERNATIVES} alternatives or {_MAX_IN_A_NAME} placeholders in a name"
        raise ParameterError(f"{text!r:.80} has more than {most}.")
    if text.startswith("/") or "\0" in text or ANY_FOLDERS in text.removeprefix(ANY_FOLDERS):
        raise ParameterError(f"{text!r:.80} must be a path in the data set, with {{}} only as its first folder.")


def alternatives(text: str) -> list[str]:
    """The patterns that a pattern with {a,b} stands for, the first ones before the others.

    Examples
    --------
    >>> alternatives("{rgb,color}/*.png")
    ['rgb/*.png', 'color/*.png']
    """
    found = _ALTERNATIVES.search(text)
    if found is None:
        return [text]
    return [
        rest
        for choice in found[1].split(",")
        for rest in alternatives(text[: found.start()] + choice.strip() + text[found.end() :])
    ]


def placeholders(text: str) -> tuple[str, ...]:
    """The names of the placeholders of a pattern without {a,b}, each once: "" for {}, numbers from 1 for *.

    Examples
    --------
    >>> placeholders("{}/{camera}/*_depth_*.png")
    ('', 'camera', '1', '2')
    """
    return tuple(dict.fromkeys(_PLACEHOLDER.findall(_numbered(text))))


def _numbered(text: str) -> str:
    """A pattern with {1}, {2}, ... in place of its stars."""
    numbers = itertools.count(1)
    return re.sub(r"\*", lambda _: f"{{{next(numbers)}}}", text)


def filled(text: str, texts: Mapping[str, str]) -> str:
    """A pattern with the text of its placeholders in their places; {} at its beginning is left out."""
    text = text.removeprefix(f"{ANY_FOLDERS}/")
    return os.path.normpath(_PLACEHOLDER.sub(lambda found: texts[found[1]], _numbered(text))).replace(os.sep, "/")


def files_like(pattern: str, folders: Folders, below: str | None = None) -> Iterator[File]:
    """The files that match a pattern, folder by folder: `*` and `{name}` stand for any text within the name of a file
    or a folder, `{}` at the beginning for any folders, also for none.

    Parameters
    ----------
    pattern : str
        Without {a,b}.
    folders : Folders
    below : str, optional
        The folders that {} stands for. None: any.
    """
    is_anywhere, parts = _compiled(pattern)
    for start in _below(folders, "", MAX_LEVELS) if is_anywhere and below is None else [below or ""]:
        for path, texts in _walk(parts, folders, start, {"_": start} if is_anywhere else {}):
            yield path, {name.removeprefix("_"): text for name, text in texts.items()}


def _walk(
    parts: Sequence[str | re.Pattern[str]], folders: Folders, folder: str, texts: dict[str, str]
) -> Iterator[File]:
    part, *deeper = parts
    content = folders.content(folder)[1 if deeper else 0]
    found: list[tuple[str, dict[str, str]]] = []
    if isinstance(part, str):
        found = [(part, texts)] if part in content else []
    else:
        for name in content:
            groups = {} if (match := part.fullmatch(name)) is None else match.groupdict()
            if match and all(texts.get(key, text) == text for key, text in groups.items()):
                found.append((name, texts | groups))
    for name, together in found:
        path = f"{folder}/{name}" if folder else name
        yield from _walk(deeper, folders, path, together) if deeper else [(path, together)]


def _below(folders: Folders, folder: str, levels: int) -> Iterator[str]:
    """A folder and those in it, up to a number of levels."""
    yield folder
    for inner in folders.inside(folder) if levels else ():
        yield from _below(folders, inner, levels - 1)


@cache
def _compiled(pattern: str) -> tuple[bool, list[str | re.Pattern[str]]]:
    """Whether a pattern begins with any folders; and the names of its folders and its file, or the expressions that
    they match."""
    parts = [part for part in _numbered(pattern).split("/") if part]
    is_anywhere = parts[:1] == [ANY_FOLDERS]
    return is_anywhere, [_expression(part) for part in parts[is_anywhere:]]


def _expression(part: str) -> str | re.Pattern[str]:
    """The name of a file or a folder, or the expression that it matches; groups are the placeholders, after _."""
    first, *pieces = _PLACEHOLDER.split(part)
    text = re.escape(first)
    for name, literal in zip(pieces[::2], pieces[1::2], strict=True):
        text += f"(?P=_{name})" if f"(?P<_{name}>" in text else f"(?P<_{name}>.+?)"
        text += re.escape(literal)
    return re.compile(text) if pieces else part

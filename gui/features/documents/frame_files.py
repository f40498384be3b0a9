"""Matching of colour and depth files by their usual names."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from ilf.io.frame_additions import guide_suffixes
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import recording_suffixes

_COLOUR_WORDS = ("rgb", "colour", "color", "image")
_DEPTH_WORDS = ("depth",)


def files_of(kind: str, suffixes: Iterable[str], *others: str) -> str:
    """Return the filters of file dialogs for files with these suffixes, others, and all files."""
    return ";;".join((f"{kind} ({' '.join(f'*{suffix}' for suffix in suffixes)})", *others, "All files (*)"))


def guide_files() -> str:
    """Return the filter of file dialogs for guides."""
    return files_of("Guides", guide_suffixes())


def recording_files() -> str:
    """Return the filter of file dialogs for recordings."""
    return f"Recordings ({' '.join(f'*{suffix}' for suffix in recording_suffixes())})"


def pair_of(path: Path) -> tuple[Path, Path] | None:
    """Return the colour and the depth file of which one is `path`, and the other lies beside it; None if none does."""
    colour = _partner(path, _DEPTH_WORDS, _COLOUR_WORDS, COLOUR_SUFFIXES) if looks_like_depth(path) else None
    depth = path if colour is not None else _partner(path, _COLOUR_WORDS, _DEPTH_WORDS, DEPTH_FILE_SUFFIXES)
    return None if depth is None else (colour or path, depth)


def looks_like_depth(path: Path) -> bool:
    """Return whether a file is depth by its name."""
    return "depth" in path.stem.lower() or path.suffix.lower() in set(DEPTH_FILE_SUFFIXES) - set(COLOUR_SUFFIXES)


def _partner(
    path: Path, own_words: tuple[str, ...], other_words: tuple[str, ...], suffixes: tuple[str, ...]
) -> Path | None:
    """Return the file beside another that has its name with the other words, or in the folder with their name."""
    own = re.compile("|".join(own_words), re.IGNORECASE)
    bare = re.sub(rf"[-_.]?({own.pattern})$", "", path.stem, flags=re.IGNORECASE)
    stems = [own.sub(word, path.stem) for word in other_words if own.search(path.stem)]
    stems += [f"{bare}_{word}" for word in other_words] + [path.stem, bare, *other_words]
    folders = [path.parent]
    if own.fullmatch(path.parent.name):
        folders += [path.parent.with_name(word) for word in other_words]
    for folder in folders:
        for stem in filter(None, stems):
            for suffix in suffixes:
                candidate = folder / (stem + suffix)
                if candidate != path and candidate.is_file():
                    return candidate
    return None

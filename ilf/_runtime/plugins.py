"""Plugins: what other installed packages offer by entry points; looked up and imported only when asked for."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import metadata
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from ..errors import IlfError, InputError

SOURCES, EXPORTERS, GUIDES = "ilf.sources", "ilf.exporters", "ilf.guides"
"""Groups of entry points."""

FAILURES = (Exception, SystemExit)
"""What a plugin may raise: its end of the program is a failure as any other."""


@cache
def entry_points(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group in all installed packages, in the order of the packages' names; none is loaded. A
    package whose list is damaged has none."""
    found: dict[str, Iterable[EntryPoint]] = {}
    for package in metadata.distributions():
        name = str(package.name)
        if name not in found:  # it hides those behind it
            found[name] = ()
            with suppress(Exception):
                found[name] = package.entry_points.select(group=group)
    return tuple(sorted((entry for own in found.values() for entry in own), key=package_of))


def package_of(entry: EntryPoint) -> str:
    """Name of the installed package that an entry point belongs to."""
    return "ilf-studio" if entry.dist is None else str(entry.dist.name)


def entry_of_file(path: str | os.PathLike[str], entries: tuple[EntryPoint, ...]) -> EntryPoint | None:
    """The entry point for a file: the one with the longest name that the file's name is, or ends in after a dot.

    Raises
    ------
    InputError
        If two packages offer the same one.
    """
    name = f".{Path(path).name.lower()}"
    fitting = [entry for entry in entries if name.endswith(f".{entry.name.lower()}")]
    if not fitting:
        return None
    chosen = max(fitting, key=lambda entry: len(entry.name))
    rivals = [package_of(entry) for entry in fitting if entry.name.lower() == chosen.name.lower()]
    if len(rivals) > 1:
        raise InputError(f"{path}: {' and '.join(rivals)} both read or write .{chosen.name}. Uninstall one of them.")
    return chosen


def load(entry: EntryPoint) -> Any:
    """Import what an entry point names; raises InputError as `call`."""
    return call(entry, entry.load)


def call(entry: EntryPoint, function: Any, *arguments: object) -> Any:
    """Call a function of a plugin.

    Raises
    ------
    IlfError
        As raised by the function.
    InputError
        In place of any other exception; the message names the package.
    """
    with named_in_errors(entry):
        return function(*arguments)


@contextmanager
def named_in_errors(entry: EntryPoint) -> Iterator[None]:
    """Within the block, turn what a plugin raises into InputError, as `call`."""
    try:
        yield
    except IlfError:
        raise
    except FAILURES as error:
        raise InputError(failure(entry, error)) from error


def failure(entry: EntryPoint, error: BaseException) -> str:
    """Describe the error of a plugin, as a sentence that names its package."""
    package = package_of(entry)
    return (
        f"The plugin {entry.name} ({entry.group}) of the package {package} failed: {type(error).__name__}: {error}. "
        f"Update the package, or remove it: pip uninstall {package}."
    )

"""Flags of the files that an export writes."""

from __future__ import annotations

import argparse

from ..run.formats import FORMATS
from ..run.options import SPACE, ExportOptions
from .parsing import add_parameter, given_parameters
from .usage import UsageError, declare


def add_export_options(group: argparse._ActionsContainer) -> None:
    """Add the flags to a parser or a group of its flags."""
    usual = ExportOptions()
    for name in ExportOptions.declarations():
        add_parameter(group, usual, name)
    formats = ", ".join(f"{name} ({format})" for name, format in FORMATS.items())
    declared = f"""
        --export FORMAT ...  also write a file for another program; can be repeated: {formats}. `ilf complete` also
            takes a FILE, in the format of its extension: one of these, .rrd for the viewer Rerun with images, blocks
            and curves (needs the package rerun-sdk), or one of plugins
    """
    declare(group, declared)


def given_exports(arguments: argparse.Namespace) -> tuple[tuple[str, ...], list[str]]:
    """Return what --export gives: formats of files among the results, and other files."""
    formats = tuple(given for given in arguments.export if given in FORMATS)
    return formats, [given for given in arguments.export if given not in FORMATS]


def export_options(arguments: argparse.Namespace, *, with_files: bool = False) -> ExportOptions:
    """Return the export options of the flags.

    Raises
    ------
    UsageError
        If the flags contradict each other, or --export gives a file, but not `with_files`.
    ParameterError
        If a value is not valid.
    """
    given = given_parameters(arguments, ExportOptions)
    has_none = given.get("cloud", "") is None and given.get("mesh") is None
    if has_none and (flags := geometry_flags(arguments)):
        raise UsageError(f"--no-cloud contradicts {', '.join(flags)}: leave it out, or add --mesh.")
    exports, files = given_exports(arguments)
    if files and not with_files:
        raise UsageError(f"--export takes a format here, not {files[0]!r:.60}: {', '.join(FORMATS)}.")
    return ExportOptions(**given, exports=exports)


def geometry_flags(arguments: argparse.Namespace) -> list[str]:
    """Return the given flags of point cloud and mesh, except --no-cloud."""
    given = given_parameters(arguments, ExportOptions)
    about = ExportOptions.declarations()
    return [about[name].flag for name, value in given.items() if about[name].group == SPACE and value is not None]

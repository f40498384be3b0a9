"""`ilf presets`: list the built-in presets and the user's own."""

from __future__ import annotations

import argparse

from ..data.declarations import Value
from ..data.parameters import PRESETS
from ..data.presets import list_presets, presets_folder
from .output import table, warn
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = "List the names that --preset accepts: built-in presets, and your own with their changes."
    parser.set_defaults(command=run)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    own = list_presets()
    rows = [(name, "built-in", "") for name in PRESETS]
    for name, preset in own.presets.items():
        extraction = {f"blocks-{key}": value for key, value in preset.extraction_changes.items()}
        rows.append((name, f"your own, from {preset.base}", _text(preset.changes | extraction)))
    print("\n".join(table(("name", "origin", "changes"), rows)))
    print(f"\nYour own presets are in {presets_folder()}")
    warn(own.problems)


def _text(values: dict[str, Value]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items()) or "none"

"""`ilf presets`: the built-in presets and one's own."""

from __future__ import annotations

import argparse

from ..data.declarations import Value
from ..data.parameters import PRESETS
from ..run.preset_files import list_presets, presets_folder
from .output import table, warn
from .parsing import Commands


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "presets",
        help="list the presets there are, built-in and your own",
        description="List the presets that --preset takes by name: the built-in ones, and your own with what differs.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    own = list_presets()
    rows = [(name, "built-in", "") for name in PRESETS]
    for name, preset in own.presets.items():
        extraction = {f"blocks-{key}": value for key, value in preset.extraction_changes.items()}
        rows.append((name, f"your own, from {preset.base}", _text(preset.changes | extraction)))
    print("\n".join(table(("name", "origin", "what differs"), rows)))
    print(f"\nYour own presets are in {presets_folder()}")
    warn(own.problems)


def _text(values: dict[str, Value]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items()) or "nothing"

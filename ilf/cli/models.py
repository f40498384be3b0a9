"""`ilf models`: list the networks for edges and guides, fetch and add some, and remove the user's own."""

from __future__ import annotations

import argparse
from importlib.metadata import metadata, packages_distributions
from operator import itemgetter
from typing import get_args

from .._runtime.networks import models as networks
from ..data.guide import Gives
from ..errors import InputError
from ..io import guide_models as guides
from ..segmentation.edges.importing import INPUTS, add_model
from .output import Bar, Column, shows_progress, table, warn
from .parsing import add_shared
from .usage import Parser, UsageError, add_action, declare

_BUNDLED = {
    networks.BUNDLED: "contours",
    networks.DEPTH_EDGES: "edges, for detector rgbd",
    networks.CORRECTION: "depth correction",
    networks.SPARSE_CORRECTION: "correction of sparse depth",
}
"""Name -> what a bundled network is for; all are under the program's licence."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = "List networks for edges and guides; fetch known guides, add and remove your own."
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)

    add_action(actions, "list", run_list, "list the networks")
    fetching = add_action(
        actions,
        "fetch",
        run_fetch,
        "fetch a known guide network from its publisher",
        description="Fetch a known guide network from its publisher, after which --guide NAME uses it. If it is "
        "interrupted, the same command continues. Nothing is fetched by any other command.",
    )
    declare(fetching, "NAME  a guide of `ilf models list`")
    add_shared(fetching, "--progress")
    adding = add_action(
        actions,
        "add",
        run_add,
        "add a network from a file",
        description="Add an edge network: an ONNX network with one image as input and its edges as last output. Or a "
        "guide network (ONNX), for a computer without network access or of your own: one with the content or the "
        "--name of a known guide, or with --gives. The network is tested before it is written.",
    )
    inputs = "; ".join(f"{name}: {text}" for name, text in INPUTS.items())
    declared = f"""
        FILE         ONNX file of the network
        --name NAME  name of the network (default: the file's name)
        --gives {"|".join(get_args(Gives))}  add a guide network of your own, and what it predicts: any decreasing
            function of depth, a linear function of inverse depth or of depth, or metres
        --input {"|".join(INPUTS)}  input of an ONNX network for edges: {inputs}
        --logits     apply a sigmoid to the output of an ONNX network
        --replace    replace your network of the same name
    """
    declare(adding, declared, input="rgb")

    removing = add_action(actions, "remove", run_remove, "delete one of your networks, or one that was fetched")
    declare(removing, "NAME  a network of `ilf models list`")


def run_list(arguments: argparse.Namespace) -> None:
    """List the networks: those for edges and correction, then the guides."""
    names = (*networks.model_names(), networks.DEPTH_EDGES, networks.CORRECTION, networks.SPARSE_CORRECTION)
    rows = [(name, *_about(name)) for name in names]
    cards, damaged = guides.guide_cards()
    rows += [
        (one.name, f"guide, {one.gives}", one.maker, guides.licence_text(one), _size(one.bytes), guides.state_of(one))
        for one in cards.values()
    ]
    headings = "name", "gives", "maker", "licence", "size", "state"
    columns = [Column(heading, itemgetter(at)) for at, heading in enumerate(headings)]
    print("\n".join(table(columns, rows)))
    print(
        "\n`ilf models fetch NAME` fetches a known guide. They are listed as their publishers describe them; none was "
        f"tried with this version. Your own and fetched networks are in {networks.models_folder()}"
    )
    warn(f"The guide network {name} is left out: {error}" for name, error in damaged.items())


def _about(name: str) -> tuple[str, str, str, str, str]:
    """What a network that is no guide gives, its maker, licence, size and state."""
    try:
        size = _size(networks.model_path(name).stat().st_size)
    except (InputError, OSError):
        size = "missing"
    if name in _BUNDLED:
        return _BUNDLED[name], "ILF Studio", "MIT", size, "bundled"
    package = networks.installed_models().get(name)
    if package is None or networks.model_path(name).parent == networks.models_folder():
        return "contours", "your own", "", size, "added"
    about = metadata(packages_distributions()[package][0])
    return "contours", f"package {about['Name']}", ", ".join(about.get_all("License-Expression", [])), size, "installed"


def run_fetch(arguments: argparse.Namespace) -> None:
    """Fetch a guide network, after its size, licence and address were printed."""
    card = guides.guide_card(arguments.name)
    if guides.guide_file(card.name) is None:
        told = f"licence {guides.licence_text(card)}; {_size(card.bytes)} from {card.address}"
        print(f"{card.name} by {card.maker}: {told}", flush=True)
    with Bar(1.0, shown=shows_progress(arguments)) as bar:
        path = guides.fetch_guide(card.name, lambda done, whole: bar.update(done / whole - bar.n))
    print(f"Ready: {path}, use it by --guide {card.name}\nSHA-256 {guides.guide_card(card.name).sha256}")


def run_add(arguments: argparse.Namespace) -> None:
    """Add a network for edges or guides."""
    file, name = arguments.file, arguments.name
    note = ""
    if arguments.gives is None and not guides.is_guide_file(file, name):
        path = add_model(file, name, inputs=arguments.input, logits=arguments.logits, replace=arguments.replace)
        if "input" not in arguments.given:
            note = (
                f"\nIt is taken as a network for edges whose input is {INPUTS['rgb']}. If its input is another, say so "
                f"by --input; if it predicts depth, it is a guide: remove it (ilf models remove {path.stem}), and add "
                f"it with what it gives, --gives {'|'.join(get_args(Gives))}."
            )
    elif arguments.logits or "input" in arguments.given:
        raise UsageError("--input and --logits are for edge networks: leave them out for a guide.")
    else:
        path = guides.add_guide(file, name, arguments.gives or "relative-inverse", again=arguments.replace)
    print(f"Added {path.stem}: {_size(path.stat().st_size)}, {path}{note}")


def run_remove(arguments: argparse.Namespace) -> None:
    """Delete a network."""
    is_guide = (
        any(arguments.name in cards for cards in guides.guide_cards()) and arguments.name not in networks.model_names()
    )
    print(f"Removed {(guides.remove_guide if is_guide else networks.remove_model)(arguments.name)}")


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB"

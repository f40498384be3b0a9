"""What the commands' arguments have in common: the frame, and the flags that parameters declare."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from ..data.camera import INTRINSICS
from ..data.declarations import Declaration, ParameterSet, Value
from ..data.frame import RGBDFrame
from ..data.parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..errors import InputError, ParameterError
from ..io.encodings import MEANINGS
from ..io.labels import also_distrusting
from ..run.preset_files import OwnPreset, find_preset
from ..sources.frame_source import FrameSource
from ..sources.source import Source, open_source
from ..sources.times import MOST_APART_S
from .output import warn
from .usage import UsageError, count

BLOCK_PREFIX = "blocks-"

MAIN_PARAMETERS = (
    *("--mode", "--smoothness", "--noise", "--max-iterations"),
    *("--blocks-granularity", "--blocks-min-size"),
)
"""The parameters that matter most, for the page of --help."""

_SWITCH = {"on": True, "true": True, "off": False, "false": False}

Set = TypeVar("Set", bound=ParameterSet)

_SEEDS = 3
"""Number of random hold-outs by default."""


def add_frame(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that name a frame and say how to read it."""
    parser.add_argument(
        "inputs",
        nargs="*",
        metavar="INPUT",
        help="colour file and depth file, or a folder with rgb.*, depth.* and meta.json. With --frame: a folder of "
        "frames, a data set or a recording",
    )
    parser.add_argument(
        "--frame",
        metavar="KEY",
        help="key of a frame in a folder, data set or recording. `ilf info` lists the keys",
    )
    add_pairing(parser)
    add_reading(parser.add_argument_group("reading the frame"))


def add_pairing(parser: argparse._ActionsContainer) -> None:
    """Add the arguments that say which colour and depth belong together: how far apart in time they may be (see
    `pairing_of`), and of which topics they are."""
    parser.add_argument(
        "--max-gap",
        type=float,
        metavar="S",
        help="largest time difference [s] between colour and depth of a frame that are paired by time (default: "
        f"{MOST_APART_S:g})",
    )
    parser.add_argument(
        "--topics",
        type=_topics,
        metavar="COLOUR,DEPTH",
        help="image topics, for ROS recordings with several cameras (default: aligned depth and its colour; `ilf info` "
        "lists them)",
    )


def pairing_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """What `add_pairing` asked for, as `open_source` takes it."""
    max_gap = MOST_APART_S if arguments.max_gap is None else float(arguments.max_gap)
    return {"max_gap": max_gap, "topics": arguments.topics}


def _topics(text: str) -> tuple[str, str]:
    colour, comma, depth = text.partition(",")
    if not (colour and comma and depth) or "," in depth:
        raise argparse.ArgumentTypeError(
            f"{text!r:.80} is not COLOUR,DEPTH, as in /camera/color/image_raw,/camera/depth"
        )
    return colour.strip(), depth.strip()


def add_reading(reading: argparse._ArgumentGroup) -> None:
    """Add the arguments that say how depth files are read and what camera they are of; see `reading_of`."""
    how = reading.add_mutually_exclusive_group()
    how.add_argument(
        "--depth-encoding",
        metavar="NAME",
        help=f"encoding of the depth file: {', '.join(MEANINGS)}, bop:SCALE, or units per metre as a number (default: "
        "from meta.json; for two files, mm for integers and m for floats). An explicit encoding skips the plausibility "
        "check",
    )
    how.add_argument(
        "--depth-units", type=float, metavar="N", help="units per metre of the depth file (1000: millimetres)"
    )
    reading.add_argument(
        "--invalid",
        type=float,
        metavar="N",
        help="value of missing depth in the depth file, besides 0: 65535 for 7-Scenes; 0 for none (default: from "
        "meta.json)",
    )
    reading.add_argument(
        "--min-confidence",
        type=float,
        metavar="N",
        help="treat depth of a lower confidence as missing, where there is a confidence map: 2 for ARKit's high "
        "(default: from meta.json, otherwise all depth is used)",
    )
    reading.add_argument(
        "--intrinsics",
        metavar="CAMERA",
        help="camera preset, fx,fy,cx,cy or a JSON file, for point clouds and meshes. Presets: "
        f"{', '.join(INTRINSICS)}",
    )


def add_strict(parser: argparse._ActionsContainer, what: str) -> None:
    """Add the flag that makes a failed plausibility check an error; `what` then happens, in words."""
    parser.add_argument(
        "--strict",
        action="store_true",
        help=f"{what} if a plausibility check of the files fails, instead of printing a warning",
    )


def check_doubts(doubts: Iterable[str], strict: bool) -> None:
    """Raise InputError for doubts about how a frame is read, if that is asked for."""
    if strict and (found := list(doubts)):
        raise InputError(" ".join(found))


def add_invalid_mask(parser: argparse.ArgumentParser) -> None:
    """Add the argument that marks known depth as invalid."""
    parser.add_argument(
        "--invalid-mask",
        metavar="MASK.png",
        help="mask of measured depth to treat as missing. For depth that is wrong: behind glass, at flying pixels, by "
        "glare. A single-channel image of the frame's size, non-zero where depth is invalid",
    )


def add_borders(parser: argparse.ArgumentParser) -> None:
    """Add the argument that marks borders of blocks that were drawn by hand."""
    parser.add_argument(
        "--borders",
        metavar="MASK.png",
        help="mask of block borders that no depth crosses, as drawn by hand: a single-channel image of the frame's "
        "size, non-zero at block pixels along such a border",
    )


def add_guide(parser: argparse.ArgumentParser) -> None:
    """Add the argument that names a frame's guide."""
    parser.add_argument(
        "--guide",
        metavar="FILE",
        help="depth or inverse depth of the frame from another source (monocular network, other sensor), in any unit: "
        "8- or 16-bit PNG, TIFF, NPY or NPZ; 0 and NaN are ignored. Its weight follows from its agreement with the "
        "known depth (default: guide.* in the frame's folder)",
    )


def add_ground_truth(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that name a frame's ground truth."""
    group = parser.add_argument_group("ground truth")
    group.add_argument(
        "--ground-truth",
        metavar="FILE",
        help="depth to evaluate the result against, in the format of the depth file (default: gt.* in the frame's "
        "folder)",
    )
    group.add_argument(
        "--ground-truth-units",
        type=float,
        metavar="N",
        help="its units per metre (default: from meta.json, otherwise those of the depth file; 1 for floats)",
    )


def add_look_in(parser: argparse.ArgumentParser) -> None:
    """Add the argument that names more folders to look for the files of a project's frames in."""
    parser.add_argument(
        "--look-in",
        action="append",
        default=[],
        metavar="DIR",
        help="folder to search for files that have been moved; can be repeated",
    )


def add_seeds(parser: argparse.ArgumentParser) -> None:
    """Add the number of hold-outs; see `seeds_of`."""
    parser.add_argument("--seeds", type=count, metavar="N", help=f"number of random hold-outs (default: {_SEEDS})")


def seeds_of(arguments: argparse.Namespace) -> tuple[int, ...]:
    """The seeds that `add_seeds` asked for."""
    return tuple(range(arguments.seeds or _SEEDS))


def add_preset(parser: argparse.ArgumentParser, **how: Any) -> None:
    """Add the argument that names a preset."""
    parser.add_argument(
        "--preset",
        metavar="PRESET",
        help=f"{', '.join(PRESETS)}, one of your own, or a preset file (default: {DEFAULT_PRESET}). `ilf presets` "
        "lists them",
        **how,
    )


def preset_from(name: str | None) -> OwnPreset:
    """The preset of an argument, the default one if it was left out; UsageError if there is none."""
    try:
        return find_preset(name or DEFAULT_PRESET)
    except ParameterError as error:
        raise UsageError(str(error)) from error


def reading_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """What the arguments of `add_reading` say, by the names that `load_frame` and `list_frames` have for it."""
    return {
        "depth_units": arguments.depth_units,
        "encoding": arguments.depth_encoding,
        "invalid": arguments.invalid,
        "intrinsics": arguments.intrinsics,
        "min_confidence": arguments.min_confidence,
    }


def source_from(arguments: argparse.Namespace) -> Source:
    """The folder of frames, data set or recording that the arguments name; what there is to say of it is told."""
    if len(arguments.inputs) != 1:
        raise UsageError(f"Name one folder of frames, data set or recording; these are {len(arguments.inputs)} paths.")
    source = open_source(arguments.inputs[0], **reading_of(arguments), **pairing_of(arguments))
    warn(source.notes)
    return source


def frame_of_source(arguments: argparse.Namespace) -> FrameSource:
    """The frame that --frame names."""
    return replace(source_from(arguments).frame_source(arguments.frame), **_beside(arguments))


def _frame_of_files(arguments: argparse.Namespace) -> FrameSource:
    inputs = arguments.inputs
    if len(inputs) not in {1, 2}:
        raise UsageError(f"Give a colour and a depth file, or one folder; these are {len(inputs)} paths.")
    if arguments.max_gap is not None or arguments.topics is not None:
        raise UsageError("--max-gap and --topics apply to frames of a folder or a recording: select one by --frame.")
    rgb, depth = inputs if len(inputs) == 2 else (inputs[0], None)
    return FrameSource(rgb, depth, **reading_of(arguments), **_beside(arguments))


def _beside(arguments: argparse.Namespace) -> dict[str, Any]:
    """Ground truth and guide that the arguments name, where the command has such."""
    given = vars(arguments)
    names = {"truth": "ground_truth", "truth_units": "ground_truth_units", "guide": "guide"}
    return {name: given.get(argument) for name, argument in names.items()}


def frame_from(arguments: argparse.Namespace) -> RGBDFrame:
    """Load the frame that the arguments name, with their invalid mask, ground truth and guide. A failed plausibility
    check is a warning, or an InputError if the command is strict."""
    frame = (_frame_of_files(arguments) if arguments.frame is None else frame_of_source(arguments)).load()
    check_doubts(frame.doubts, vars(arguments).get("strict", False))
    warn(frame.notes)
    return frame if arguments.invalid_mask is None else also_distrusting(frame, arguments.invalid_mask)


def add_block_parameters(parser: argparse.ArgumentParser) -> None:
    """Add the flags of the block extraction."""
    add_parameters(parser, BlockParameters, "block extraction", prefix=BLOCK_PREFIX)


def add_parameters(
    parser: argparse.ArgumentParser,
    kind: type[ParameterSet],
    title: str,
    *,
    prefix: str = "",
    presets: Mapping[str, ParameterSet] | None = None,
    default: str | None = None,
) -> None:
    """Add a flag for every parameter of a set, group by group, each with its help, unit, range and default.

    Parameters
    ----------
    parser : ArgumentParser
    kind : type of ParameterSet
    title : str
        Put before the names of the groups.
    prefix : str
        Put before the name of every flag.
    presets : mapping, optional
        Named sets; where their values differ from the default, the help says so.
    default : str, optional
        The preset whose values are the defaults; the declared ones are if it is left out.
    """
    groups: dict[str, Any] = {}
    base = kind() if presets is None or default is None else presets[default]
    for name, declaration in kind.declarations().items():
        if declaration.group not in groups:
            groups[declaration.group] = parser.add_argument_group(f"{title}: {declaration.group.lower()}")
        how: dict[str, Any] = (
            {"action": argparse.BooleanOptionalAction}
            if declaration.kind is bool
            else {
                "type": _reader(declaration),
                "choices": declaration.choices or None,
                "metavar": _metavar(declaration),
            }
        )
        groups[declaration.group].add_argument(
            declaration.flag.replace("--", f"--{prefix}", 1),
            dest=_destination(kind, name),
            default=argparse.SUPPRESS,
            help=_help(declaration, presets or {}, base).replace("%", "%%"),
            **how,
        )


def given_parameters(arguments: argparse.Namespace, kind: type[ParameterSet]) -> dict[str, Value]:
    """Name -> value of the parameters of a set that were given on the command line."""
    values = vars(arguments)
    return {
        name: values[_destination(kind, name)] for name in kind.declarations() if _destination(kind, name) in values
    }


def parameter_flags(arguments: argparse.Namespace) -> list[str]:
    """The flags of parameters, of filter and extraction, that were given on the command line."""
    return [
        f"--{prefix}{name.replace('_', '-')}"
        for kind, prefix in ((Parameters, ""), (BlockParameters, BLOCK_PREFIX))
        for name in given_parameters(arguments, kind)
    ]


def with_given(base: Set, arguments: argparse.Namespace) -> Set:
    """A parameter set with what was given on the command line; UsageError for a parameter that has no effect so."""
    try:
        return base.changed(**given_parameters(arguments, type(base)))
    except ParameterError as error:
        raise UsageError(str(error)) from error


def _destination(kind: type[ParameterSet], name: str) -> str:
    return f"{kind.__name__}.{name}"


def _reader(declaration: Declaration) -> Callable[[str], Value]:
    """Turns a flag's text into a checked value; argparse shows the message of what it raises."""

    def read(text: str) -> Value:
        try:
            return value_from(declaration, text)
        except ParameterError as error:
            raise argparse.ArgumentTypeError(str(error).rstrip(".")) from error

    return read


def value_from(declaration: Declaration, text: str) -> Value:
    """A parameter's value from what someone wrote; ParameterError if it is none."""
    if declaration.special and text == declaration.special and declaration.minimum is not None:
        return declaration.checked(declaration.minimum)
    if declaration.kind is bool:
        if text not in _SWITCH:
            raise ParameterError(f"{declaration.name} must be on or off, not {text!r:.40}.")
        return _SWITCH[text]
    if declaration.kind is str:
        return declaration.checked(text)
    try:
        number = float(text)
    except ValueError as error:
        raise ParameterError(f"{text!r} is not a number.") from error
    return declaration.checked(number)


def _metavar(declaration: Declaration) -> str:
    if declaration.choices:
        return "|".join(declaration.choices)
    return "TEXT" if declaration.kind is str else "N"


def _help(declaration: Declaration, presets: Mapping[str, ParameterSet], base: ParameterSet) -> str:
    facts = [declaration.unit] if declaration.unit else []
    if declaration.minimum is not None and declaration.maximum is not None:
        facts.append(f"{declaration.minimum:g} to {declaration.maximum:g}")
    usual = getattr(base, declaration.name)
    facts.append(f"default {_shown(declaration, usual)}")
    for preset, values in presets.items():
        value = getattr(values, declaration.name)
        if value != usual:
            facts.append(f"in {preset} {_shown(declaration, value)}")
    return f"{declaration.help} [{'; '.join(facts)}]"


def _shown(declaration: Declaration, value: Value) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return declaration.special if declaration.special and value == declaration.minimum else str(value)

"""Arguments shared by the commands: the frame, and the flags of the parameters."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from .._runtime.networks.session import DEVICE_VARIABLE, DEVICES
from ..data.by_hand import USUAL_WEIGHT
from ..data.declarations import Declaration, ParameterSet, Value
from ..data.frame import RGBDFrame
from ..data.parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..data.presets import UserPreset, find_preset
from ..errors import InputError, ParameterError
from ..io.labels import with_more_invalid
from ..sources.frame_ref import FrameRef
from ..sources.neighbours import with_neighbours
from ..sources.reading import read_frame
from ..sources.reading_options import KINDS, OPTIONS, ReadingOption, ReadingOptions
from ..sources.source import Source
from .output import warn
from .usage import UsageError, count

BLOCK_PREFIX = "blocks-"

_SWITCH = {"on": True, "true": True, "off": False, "false": False}

Set = TypeVar("Set", bound=ParameterSet)

_SEEDS = 3
"""Number of random hold-outs by default."""


def add_frame(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of a frame and of how to read it."""
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
    """Add the arguments of the reading options of a source: time difference, topics and layout."""
    add_options(parser, {name: option for name, option in OPTIONS.items() if option.of_source})


def _topics(text: str) -> tuple[str, str]:
    colour, comma, depth = text.partition(",")
    if not (colour and comma and depth) or "," in depth:
        raise argparse.ArgumentTypeError(
            f"{text!r:.80} is not COLOUR,DEPTH, as in /camera/color/image_raw,/camera/depth"
        )
    return colour.strip(), depth.strip()


def add_reading(parser: argparse._ActionsContainer) -> None:
    """Add the arguments of the reading options of all frames, see `reading_options`, and of what files may name."""
    of_all = {name: option for name, option in OPTIONS.items() if not (option.one_frame or option.of_source)}
    add_options(parser, of_all)
    add_allowed(parser)


def add_companions(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the reading options of a single frame: its guide and its ground truth."""
    add_options(parser, {name: option for name, option in OPTIONS.items() if option.one_frame and not option.group})
    for title in dict.fromkeys(option.group for option in OPTIONS.values() if option.group):
        group = parser.add_argument_group(title)
        add_options(group, {name: option for name, option in OPTIONS.items() if option.group == title})


def add_options(parser: argparse._ActionsContainer, options: Mapping[str, ReadingOption]) -> None:
    """Add the flags of reading options."""
    exclusive = parser.add_mutually_exclusive_group()
    for name, option in options.items():
        if bool in KINDS[name]:
            parser.add_argument(option.flag, dest=name, action="store_const", const=True, help=option.help)
        elif option.flag:
            (exclusive if option.exclusive else parser).add_argument(
                option.flag,
                dest=name,
                type=str if str in KINDS[name] else _topics if name == "topics" else float,
                metavar=option.metavar,
                help=option.help,
            )


def add_strict(parser: argparse._ActionsContainer, what: str) -> None:
    """Add the flag that turns plausibility warnings into errors; `what` is the effect, for the help."""
    parser.add_argument(
        "--strict",
        action="store_true",
        help=f"{what} if a plausibility check of the files fails, instead of printing a warning",
    )


def check_plausibility(plausibility_warnings: Iterable[str], strict: bool) -> None:
    """Raise InputError for plausibility warnings if `strict`."""
    if strict and (found := list(plausibility_warnings)):
        raise InputError(" ".join(found))


def add_invalid_mask(parser: argparse.ArgumentParser) -> None:
    """Add the argument of the invalid mask."""
    parser.add_argument(
        "--invalid-mask",
        metavar="MASK.png",
        help="mask of measured depth to treat as missing, because it is wrong: behind glass, at flying pixels, by "
        "glare. A single-channel image of the frame's size, non-zero where depth is invalid",
    )


def add_neighbours(parser: argparse._ActionsContainer) -> None:
    """Add the arguments of the neighbours whose depth is added; see `ilf.with_neighbours`."""
    parser.add_argument(
        "--neighbours",
        type=count,
        metavar="N",
        help="also use the depth that N frames before and N after have measured, where a frame has none. Needs "
        "intrinsics, and poses or the package open3d (extra app). The pixels are marked in from_neighbours.png",
    )
    parser.add_argument(
        "--neighbour-step",
        type=count,
        metavar="M",
        help="with --neighbours: use every M-th frame before and after (default: 1)",
    )


def checked_neighbours(arguments: argparse.Namespace) -> tuple[int, int]:
    """Return the values of `add_neighbours`, 0 and 1 if not given; raises UsageError for a step without neighbours."""
    if arguments.neighbours is None and arguments.neighbour_step is not None:
        raise UsageError("--neighbour-step applies to --neighbours: add it.")
    return arguments.neighbours or 0, arguments.neighbour_step or 1


def add_borders(parser: argparse.ArgumentParser) -> None:
    """Add the argument of the mask of block borders drawn by hand."""
    parser.add_argument(
        "--borders",
        metavar="MASK.png",
        help="mask of block borders that no depth crosses, as drawn by hand: a single-channel image of the frame's "
        "size, non-zero at block pixels along such a border",
    )


def add_by_hand(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of depth by hand and its weight."""
    parser.add_argument(
        "--depth-by-hand",
        metavar="FILE",
        help="depth that you state where it is missing or marked invalid: an image in the encoding of the frame's "
        "depth, or floating-point numbers in metres, such as NPY; 0 or NaN states none. It is marked in the results "
        "(by_hand.png) and never counts as measured",
    )
    parser.add_argument(
        "--by-hand-weight",
        metavar="WEIGHT",
        type=float,
        help=f"weight of a pixel's depth by hand, 0 to 1; a measured pixel has weight 1 (default: {USUAL_WEIGHT:g})",
    )


def add_look_in(parser: argparse.ArgumentParser) -> None:
    """Add the argument of folders in which the files of a project's frames are now."""
    parser.add_argument(
        "--look-in",
        action="append",
        default=[],
        metavar="DIR",
        help="folder where files that have been moved are now; can be repeated",
    )


def add_allowed(parser: argparse._ActionsContainer) -> None:
    """Add the argument of places that files may name; see `ilf.sources.allow_address`."""
    parser.add_argument(
        "--allow-address",
        action="append",
        default=[],
        metavar="PREFIX",
        help="open what files name (projects, run records, lists, shards) at and below this address or path, outside "
        "their own folder or store; can be repeated",
    )


def add_seeds(parser: argparse.ArgumentParser) -> None:
    """Add the argument of the number of hold-outs; see `seeds_from`."""
    parser.add_argument("--seeds", type=count, metavar="N", help=f"number of random hold-outs (default: {_SEEDS})")


def seeds_from(arguments: argparse.Namespace) -> tuple[int, ...]:
    """Return the seeds of `add_seeds`."""
    return tuple(range(arguments.seeds or _SEEDS))


def add_preset(parser: argparse.ArgumentParser, **how: Any) -> None:
    """Add the argument of the preset."""
    parser.add_argument(
        "--preset",
        metavar="PRESET",
        help=f"{', '.join(PRESETS)}, one of your own, or a preset file (default: {DEFAULT_PRESET}). `ilf presets` "
        "lists them",
        **how,
    )


def preset_from(name: str | None) -> UserPreset:
    """Return a preset by its name, None for the default; raises UsageError if there is none."""
    try:
        return find_preset(name or DEFAULT_PRESET)
    except ParameterError as error:
        raise UsageError(str(error)) from error


def reading_options(arguments: argparse.Namespace) -> ReadingOptions:
    """Return the values of `add_reading` and `add_companions`."""
    return ReadingOptions.from_arguments(vars(arguments))


def reading_flags(arguments: argparse.Namespace) -> list[str]:
    """Return the flags of reading options that are given on the command line."""
    return [OPTIONS[name].flag for name in reading_options(arguments).given]


def source_from(arguments: argparse.Namespace) -> Source:
    """Open the folder of frames, data set or recording that the arguments name, and print its warnings."""
    if len(arguments.inputs) != 1:
        raise UsageError(f"Give one folder of frames, data set or recording, not {len(arguments.inputs)} paths.")
    source = Source(arguments.inputs[0], reading_options(arguments))
    warn(source.notes)
    return source


def frame_of_source(arguments: argparse.Namespace, source: Source | None = None) -> FrameRef:
    """Return the frame that --frame selects, from a source if it is already open."""
    found = (source or source_from(arguments)).ref(arguments.frame)
    return replace(found, options=reading_options(arguments).of_frame.or_else(found.options))


def _frame_with_neighbours(arguments: argparse.Namespace, count: int, step: int) -> RGBDFrame:
    """Load the frame that --frame selects, with the depth of its neighbours."""
    if arguments.frame is None:
        raise UsageError("--neighbours applies to frames of a folder or a recording: select one with --frame.")
    source = source_from(arguments)
    frame = read_frame(frame_of_source(arguments, source))
    return with_neighbours(frame, *source.around(arguments.frame, count * step), step=step)


def _frame_of_files(arguments: argparse.Namespace) -> FrameRef:
    inputs, options = arguments.inputs, reading_options(arguments)
    if len(inputs) not in {1, 2}:
        raise UsageError(f"Give a colour and a depth file, or one folder, not {len(inputs)} paths.")
    if options != options.of_frame:
        raise UsageError(
            "--max-gap, --topics and --layout apply to frames of a folder or a recording: select one with --frame."
        )
    rgb, depth = inputs if len(inputs) == 2 else (inputs[0], None)
    return FrameRef(rgb, depth, options=options)


def frame_from(arguments: argparse.Namespace) -> RGBDFrame:
    """Load the frame that the arguments name, with its invalid mask, ground truth and guide. Plausibility warnings are
    printed; with --strict they raise InputError."""
    neighbours, step = checked_neighbours(arguments) if "neighbours" in arguments else (0, 1)
    if neighbours:
        frame = _frame_with_neighbours(arguments, neighbours, step)
    else:
        frame = read_frame(_frame_of_files(arguments) if arguments.frame is None else frame_of_source(arguments))
    check_plausibility(frame.plausibility_warnings, vars(arguments).get("strict", False))
    warn(frame.notes)
    return frame if arguments.invalid_mask is None else with_more_invalid(frame, arguments.invalid_mask)


def add_block_parameters(parser: argparse.ArgumentParser) -> None:
    """Add the flags of the block extraction, and that of the device."""
    add_parameters(parser, BlockParameters, "block extraction", prefix=BLOCK_PREFIX)
    parser.add_argument(
        "--device",
        action=_Device,
        choices=list(DEVICES),
        help="device that runs the networks. Others than cpu need another distribution of ONNX Runtime (default: cpu, "
        f"or the environment variable {DEVICE_VARIABLE})",
    )


class _Device(argparse.Action):
    def __call__(
        self, parser: object, namespace: argparse.Namespace, values: Any, option_string: object = None
    ) -> None:
        os.environ[DEVICE_VARIABLE] = namespace.device = values


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
        Prefix of the groups' names.
    prefix : str
        Prefix of the flags' names.
    presets : mapping, optional
        Named sets; the help lists their values that differ from the default.
    default : str, optional
        Preset with the default values; the declared defaults are used if left out.
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
    """Return name -> value of the parameters of a set that are given on the command line."""
    values = vars(arguments)
    return {
        name: values[_destination(kind, name)] for name in kind.declarations() if _destination(kind, name) in values
    }


def parameter_flags(arguments: argparse.Namespace) -> list[str]:
    """Return the flags of filter and extraction parameters that are given on the command line."""
    return [
        f"--{prefix}{name.replace('_', '-')}"
        for kind, prefix in ((Parameters, ""), (BlockParameters, BLOCK_PREFIX))
        for name in given_parameters(arguments, kind)
    ]


def with_given(base: Set, arguments: argparse.Namespace) -> Set:
    """Return a parameter set changed as given on the command line; UsageError for a parameter without effect."""
    try:
        return base.changed(**given_parameters(arguments, type(base)))
    except ParameterError as error:
        raise UsageError(str(error)) from error


def _destination(kind: type[ParameterSet], name: str) -> str:
    return f"{kind.__name__}.{name}"


def _reader(declaration: Declaration) -> Callable[[str], Value]:
    """Return a function that converts a flag's text to a checked value; argparse prints its error message."""

    def read(text: str) -> Value:
        try:
            return value_from(declaration, text)
        except ParameterError as error:
            raise argparse.ArgumentTypeError(str(error).rstrip(".")) from error

    return read


def value_from(declaration: Declaration, text: str) -> Value:
    """Parse the value of a parameter; raises ParameterError if it is not valid."""
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

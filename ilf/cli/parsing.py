"""Arguments shared by the commands: the frame, the settings of a run, and the flags of what is declared, parameters and
options of an export."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

from .._runtime.files import absolute
from .._runtime.networks.models import model_path
from .._runtime.networks.network import DEVICE_VARIABLE, DEVICES
from ..data.by_hand import USUAL_WEIGHT
from ..data.declarations import Declaration, ParameterSet, Value
from ..data.frame import RGBDFrame
from ..data.parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..data.presets import BUILT_IN, UserPreset, find_preset
from ..errors import InputError, ParameterError, told_as
from ..evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest
from ..io.images import read_mask
from ..run.formats import FORMATS
from ..run.options import SPACE, ExportOptions
from ..run.run import BlockChoice
from ..segmentation.edges.frame_edges import CANNY_INSTEAD
from ..sources.frame_ref import KINDS, OPTIONS, FrameRef, ReadingOption, ReadingOptions
from ..sources.neighbours import with_neighbours
from ..sources.reading import read_frame
from ..sources.source import Source
from .output import warn
from .usage import UsageError, declare, parsed

BLOCK_PREFIX = "blocks-"

_SWITCH = {"on": True, "true": True, "off": False, "false": False}

Set = TypeVar("Set", bound=ParameterSet)

_HOLD_OUTS = "; ".join(f"{name}: {what}" for name, what in HOLD_OUT_PATTERNS.items())

_SHARED = f"""
    --strict             fail, or fail the frame of a batch, if a plausibility check of the files fails, instead of
        printing a warning
    --invalid-mask MASK.png  mask of measured depth to treat as missing, because it is wrong: behind glass, at flying
        pixels, by glare. A single-channel image of the frame's size, non-zero where depth is invalid
    --neighbours N       also use the depth that N frames before and N after have measured, where a frame has none.
        Needs intrinsics, and poses or the package open3d (extra app). The pixels are marked in from_neighbours.png
    --neighbour-step M   with --neighbours: use every M-th frame before and after
    --drawn MASK.png     mask of drawn borders of blocks, which no depth crosses: a single-channel image of the frame's
        size, non-zero at block pixels along such a border
    --by-hand FILE       depth that you state where it is missing or marked invalid: an image in the encoding of the
        frame's depth, or floating-point numbers in metres, such as NPY; 0 or NaN states none. It is marked in the
        results (by_hand.png) and never counts as measured
    --by-hand-weight WEIGHT  with --by-hand: weight of its pixels, 0 to 1; a measured pixel has weight 1
    --extrapolate        extrapolate the depth that is still missing after the run, and write its mask extrapolated.png
    --hold-out {"|".join(HOLD_OUT_PATTERNS)}  evaluate on hold-out depth of this pattern, with a run per seed:
        {_HOLD_OUTS}
    --seeds N            number of random hold-outs
    --look-in DIR ...    folder where files that have been moved are now; can be repeated
    --allow-address PREFIX ...  open what files name (projects, run records, lists, shards) at and below this address or
        path, outside their own folder or store; can be repeated
    --json               print one JSON document instead of text (keys: commands.md of the documentation). Unknown
        numbers are null, lengths in metres
    --[no-]progress      show a progress bar on stderr (default: on if stderr is a terminal)
    --quiet              print only warnings and errors
"""
"""The flags that several commands have."""


def add_shared(parser: argparse._ActionsContainer, *flags: str) -> None:
    """Add some of the flags that several commands have."""
    declare(parser, _SHARED, flags, neighbours=0, neighbour_step=1, by_hand_weight=USUAL_WEIGHT, seeds=3)


def add_frame(parser: argparse.ArgumentParser, *, companions: bool = True) -> None:
    """Add the arguments of a frame and of how to read it; with `companions`, of its guide and ground truth."""
    inputs = """
        [INPUT ...]  colour file and depth file, or a folder with rgb.*, depth.* and meta.json. With --frame: a folder
            of frames, a data set or a recording
    """
    declare(parser, inputs)
    group = parser.add_argument_group("reading the frame")
    declare(group, "--frame KEY  key of a frame in a folder, data set or recording. `ilf info` lists the keys")
    add_pairing(group)
    add_reading(group)
    if companions:
        add_options(group, {name: option for name, option in OPTIONS.items() if option.one_frame})


def add_pairing(parser: argparse._ActionsContainer) -> None:
    """Add the arguments of the reading options of a source: time difference, topics and layout."""
    add_options(parser, {name: option for name, option in OPTIONS.items() if option.of_source})


_topics = parsed(
    r"\s*([^,]+?)\s*,\s*([^,]+?)\s*",
    "COLOUR,DEPTH, as in /camera/color/image_raw,/camera/depth",
    lambda match: (match[1], match[2]),
)


def add_reading(parser: argparse._ActionsContainer) -> None:
    """Add the arguments of the reading options of all frames, see `reading_options`, and of what files may name."""
    of_all = {name: option for name, option in OPTIONS.items() if not (option.one_frame or option.of_source)}
    add_options(parser, of_all)
    add_shared(parser, "--allow-address")


def add_options(parser: argparse._ActionsContainer, options: Mapping[str, ReadingOption]) -> None:
    """Add the flags of reading options."""
    # argparse cannot print the usage of an empty group
    some = any(option.exclusive for option in options.values())
    exclusive = parser.add_mutually_exclusive_group() if some else parser
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


def check_plausibility(plausibility_warnings: Iterable[str], strict: bool) -> None:
    """Raise InputError for plausibility warnings if `strict`."""
    if strict and (found := list(plausibility_warnings)):
        raise InputError(" ".join(found))


def hold_out_from(arguments: argparse.Namespace) -> HoldOutTest | None:
    """Return the hold-out that is asked for, if any; raises UsageError for a number of seeds without one."""
    if arguments.hold_out is None and "seeds" in arguments.given:
        raise UsageError("--seeds applies to hold-out only: add --hold-out.")
    return None if arguments.hold_out is None else HoldOutTest(arguments.hold_out, tuple(range(arguments.seeds)))


def add_preset(parser: argparse._ActionsContainer, several: bool = False) -> None:
    """Add the flag of the preset."""
    preset = f"""
        --preset PRESET{" ..." * several}  {", ".join(PRESETS)}, one of your own, or a preset file
            (default: {DEFAULT_PRESET}). `ilf info --presets` lists them
    """
    declare(parser, preset)


def add_settings(parser: argparse.ArgumentParser, several_presets: bool = False) -> None:
    """Add the flags of preset, filter and extraction."""
    add_preset(parser.add_argument_group("preset"), several_presets)
    add_parameters(parser, "filter", PRESETS[DEFAULT_PRESET], presets=PRESETS)
    add_block_parameters(parser)


def preset_from(name: str | None) -> UserPreset:
    """Return a preset by its name, None for the default; raises UsageError if there is none."""
    if not name:
        return BUILT_IN[DEFAULT_PRESET]
    with told_as(UsageError, "{error}", ParameterError):
        return find_preset(name)


def settings_from(arguments: argparse.Namespace, preset: UserPreset) -> tuple[Parameters, BlockChoice]:
    """Return the parameters of the filter and the choice of blocks, based on a preset."""
    values = vars(arguments)
    extraction = extraction_from(arguments, "--blocks", preset.extraction)
    named = (values.get(name) for name in ("blocks", "drawn", "by_hand"))
    blocks, drawn, by_hand = (None if path is None else absolute(path) for path in named)
    weight = values.get("by_hand_weight", USUAL_WEIGHT)
    choice = BlockChoice(extraction, blocks, values.get("fill_gaps", False), drawn, by_hand, weight)
    return with_given(preset.parameters, arguments), choice


def missing_networks(parameters: Parameters, blocks: BlockChoice) -> Iterator[str]:
    """Say of each edge network of the settings that is not on this computer what takes its place."""
    for name in {parameters.model, blocks.extraction.model}:
        try:
            model_path(name)
        except InputError as error:
            yield f"{CANNY_INSTEAD}: {error}"


def add_given_blocks(group: argparse._ActionsContainer, flag: str) -> None:
    """Add the arguments of given blocks, and of filling their gaps."""
    group.add_argument(
        flag,
        dest="blocks",
        metavar="PATH",
        help="use these blocks instead of extracting them. Formats: label map (PNG), labelme or COCO JSON, "
        "segment-anything masks (JSON) or a folder of masks (PNG); where masks overlap, the smallest is on top",
    )
    declare(group, f"--fill-gaps  with {flag}: extract blocks in the gaps of these")


def extraction_from(arguments: argparse.Namespace, flag: str, base: BlockParameters | None = None) -> BlockParameters:
    """Return the extraction parameters, based on `base`; UsageError for arguments without effect beside the flag of
    given blocks."""
    is_given = vars(arguments).get("blocks") is not None and not arguments.fill_gaps
    if is_given and given_parameters(arguments, BlockParameters):
        raise UsageError(f"With {flag} nothing is extracted: leave out --{BLOCK_PREFIX}* flags, or add --fill-gaps.")
    return with_given(base or BlockParameters(), arguments)


def reading_options(arguments: argparse.Namespace) -> ReadingOptions:
    """Return the reading options that are given."""
    return ReadingOptions.from_arguments(vars(arguments))


def source_from(arguments: argparse.Namespace) -> Source:
    """Open the folder of frames, data set or recording that the arguments name, and print its warnings."""
    if len(arguments.inputs) != 1:
        raise UsageError(f"Give one folder of frames, data set or recording, not {len(arguments.inputs)} paths.")
    source = Source(arguments.inputs[0], reading_options(arguments))
    warn(source.notes)
    return source


def frame_of_source(arguments: argparse.Namespace, source: Source) -> FrameRef:
    """Return the frame of a source that --frame selects."""
    found = source.ref(arguments.frame)
    return replace(found, options=reading_options(arguments).of_frame.or_else(found.options))


def _frame_of_files(arguments: argparse.Namespace) -> FrameRef:
    inputs, options = arguments.inputs, reading_options(arguments)
    if len(inputs) not in {1, 2}:
        raise UsageError(f"Give a colour and a depth file, or one folder, not {len(inputs)} paths.")
    if options != options.of_frame:
        raise UsageError("--max-gap, --topics and --layout are for folders and recordings: select one with --frame.")
    rgb, depth = inputs if len(inputs) == 2 else (inputs[0], None)
    return FrameRef(rgb, depth, options=options)


def frame_from(arguments: argparse.Namespace) -> RGBDFrame:
    """Load the frame that the arguments name, with its invalid mask, ground truth and guide. Plausibility warnings are
    printed; with --strict they raise InputError."""
    neighbours = vars(arguments).get("neighbours", 0)
    if arguments.frame is None:
        if neighbours:
            raise UsageError("--neighbours applies to frames of a folder or a recording: select one with --frame.")
        frame = read_frame(_frame_of_files(arguments))
    else:
        source = source_from(arguments)
        frame = read_frame(frame_of_source(arguments, source))
        if neighbours:
            step = arguments.neighbour_step
            frame = with_neighbours(frame, *source.around(arguments.frame, neighbours * step), step=step)
    check_plausibility(frame.plausibility_warnings, vars(arguments).get("strict", False))
    warn(frame.notes)
    mask = arguments.invalid_mask
    return frame if mask is None else frame.with_more_invalid(read_mask(mask, frame.shape))


def add_block_parameters(parser: argparse.ArgumentParser) -> None:
    """Add the flags of the block extraction, and that of the device."""
    add_parameters(parser, "block extraction", BlockParameters(), prefix=BLOCK_PREFIX)
    device = f"""
        --device {"|".join(DEVICES)}  device that runs the networks. Others than cpu need another distribution of ONNX
            Runtime (default: cpu, or the environment variable {DEVICE_VARIABLE})
    """
    declare(parser, device)


def add_parameters(
    parser: argparse.ArgumentParser,
    title: str,
    base: ParameterSet,
    *,
    presets: Mapping[str, ParameterSet] | None = None,
    prefix: str = "",
) -> None:
    """Add a flag for every parameter of a set, group by group, each with its help, unit, range, default (that of
    `base`) and values in presets."""
    groups: dict[str, argparse._ArgumentGroup] = {}
    for name, declaration in base.declarations().items():
        if declaration.group not in groups:
            groups[declaration.group] = parser.add_argument_group(f"{title}: {declaration.group.lower()}")
        add_parameter(groups[declaration.group], base, name, presets or {}, prefix)


def add_parameter(
    group: argparse._ActionsContainer,
    base: ParameterSet,
    name: str,
    presets: Mapping[str, ParameterSet] = MappingProxyType({}),
    prefix: str = "",
) -> None:
    """Add the flag of a parameter, if it has one, as `add_parameters` does."""
    declaration = base.declarations()[name]
    if not declaration.flag:
        return
    flag, about = declaration.flag.replace("--", f"--{prefix}", 1), _help(declaration, presets, base)
    kind, choices = declaration.kind, declaration.choices
    dest: dict[str, Any] = {"dest": _destination(type(base), name), "default": argparse.SUPPRESS}
    how: dict[str, Any] = {"help": about.replace("%", "%%"), **dest}
    if declaration.or_none:
        group = group.add_mutually_exclusive_group()
    if kind is bool:
        how["action"] = argparse.BooleanOptionalAction
    elif kind is str and choices:
        how |= {"choices": choices, "metavar": "|".join(choices)}
    else:
        how |= {"type": _reader(declaration), "metavar": "LIST" if kind is tuple else "TEXT" if kind is str else "N"}
    group.add_argument(flag, **how)
    if declaration.or_none and declaration.default is not None:
        none = flag.replace("--", "--no-", 1)
        group.add_argument(none, action="store_const", const=None, help=f"Write no {name}.", **dest)


def given_parameters(arguments: argparse.Namespace, kind: type[ParameterSet]) -> dict[str, Any]:
    """Return name -> value of the parameters of a set that are given on the command line."""
    values = vars(arguments)
    return {
        name: values[_destination(kind, name)] for name in kind.declarations() if _destination(kind, name) in values
    }


def with_given(base: Set, arguments: argparse.Namespace) -> Set:
    """Return a parameter set changed as given on the command line; UsageError for a parameter without effect."""
    with told_as(UsageError, "{error}", ParameterError):
        return base.changed(**given_parameters(arguments, type(base)))


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


def value_from(declaration: Declaration, text: str) -> Any:
    """Parse the value of a parameter; raises ParameterError if it is not valid."""
    if declaration.special and text == declaration.special and declaration.minimum is not None:
        return declaration.checked(declaration.minimum)
    if declaration.kind is bool:
        if text not in _SWITCH:
            raise ParameterError(f"{declaration.name} must be on or off, not {text!r:.40}.")
        return _SWITCH[text]
    if declaration.kind is str:
        return declaration.checked(text)
    if declaration.kind is tuple:
        return declaration.checked([*filter(None, text.split(","))])
    with told_as(ParameterError, f"{text!r} is not a number.", ValueError):
        number = float(text)
    return declaration.checked(number)


def _help(declaration: Declaration, presets: Mapping[str, ParameterSet], base: ParameterSet) -> str:
    usual, facts = getattr(base, declaration.name), []
    if declaration.minimum is not None and declaration.maximum is not None:
        facts.append(f"{declaration.minimum:g} to {declaration.maximum:g} {declaration.unit}".rstrip())
    if declaration.kind is tuple:
        facts.append(f"any of {','.join(declaration.choices)}")
    facts.append(f"default {declaration.to_text(usual)}")
    values = {preset: getattr(parameters, declaration.name) for preset, parameters in presets.items()}
    facts += [f"in {preset} {declaration.to_text(value)}" for preset, value in values.items() if value != usual]
    return f"{declaration.help} [{'; '.join(facts)}]"


# What an export writes.


def add_export_options(group: argparse._ActionsContainer) -> None:
    """Add the flags to a parser or a group of its flags."""
    usual = ExportOptions()
    for name in ExportOptions.declarations():
        add_parameter(group, usual, name)
    about: dict[str, list[str]] = {}
    for name, format in FORMATS.items():
        about.setdefault(format.group, []).append(f"{name} ({format.title})")
    formats = "; ".join(f"of {group}: {', '.join(named)}" for group, named in about.items())
    declared = f"""
        --export FORMAT ...  also write a file for another program; can be repeated. Formats {formats}. `ilf
            complete` also takes a FILE, in the format of its extension: one of these, .rrd for the viewer Rerun with
            images, blocks and curves (needs the package rerun-sdk), or one of plugins
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
    """Return the given flags of point cloud and mesh, except those that leave something out."""
    given = given_parameters(arguments, ExportOptions)
    about = ExportOptions.declarations()
    chosen = [name for name, value in given.items() if about[name].group == SPACE and value]
    return [arguments.given[_destination(ExportOptions, name)] for name in chosen]

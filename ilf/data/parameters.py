"""The parameters of EBS and of ILF, and the presets. Plain data: nothing here computes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .._runtime.networks.models import BUNDLED, model_names
from ..errors import ParameterError
from .declarations import ParameterSet, Value, check_names, declare, described

_BLOCKS, _EDGES, _BOUNDARIES = "Blocks", "Edges", "Boundaries"
_OUTPUT, _SCHEDULE, _STOP, _COLOUR, _DATA = "Output", "Pass band", "Stopping", "Colour", "Data"
_SMOOTH, _SOFT = "Smoothness", "Edges"
_BY_NETWORK, _HED, _DEPTH = ("detector", "rgbd", "hed"), ("detector", "hed"), ("use_depth", True)
_COMBINED = ("edges", "combined")
_IDEAL, _EDGE_AWARE = ("filter", "ideal"), ("filter", "edge-aware")


@described
@dataclass(frozen=True)
class BlockParameters(ParameterSet):
    """Parameters of EBS, the extraction of boundaries and surfaces. Lengths in pixels of the frame."""

    granularity: float = declare(
        0.5, "Granularity", "From 0, few large blocks, which only depth jumps and the strongest edges part, to 1, many "
        "small ones.", _BLOCKS, minimum=0.0, maximum=1.0, step=0.05, source="not in the paper",
    )  # fmt: skip
    min_size: float = declare(
        0.5, "Smallest block", "Regions below this share of the frame are not blocks of their own; "
        "their neighbours take them in.", _BLOCKS,
        unit="% of frame", minimum=0.0, maximum=50.0, step=0.1, scale="log", source="section 2; released code: 1.14 %",
    )  # fmt: skip
    min_known_share: float = declare(
        0.05, "Known share, at least", "Regions where a smaller share of the pixels has depth are not blocks of their "
        "own; their neighbours take them in.", _BLOCKS, minimum=0.0, maximum=1.0, step=0.01,
        source="section 2",
    )  # fmt: skip
    existence_rate: float = declare(
        0.0, "Existence rate", "Blocks where a smaller share of the pixels has depth are halved, up to twice, and only "
        "the parts that reach it are kept. The rest belongs to no block and stays missing.", _BLOCKS,
        minimum=0.0, maximum=1.0, step=0.01, special="off", source="section 2; released code: 0.52",
    )  # fmt: skip
    detector: str = declare(
        "hed", "Edges from", "rgbd: a network that looks at colour and known depth, and finds where depth jumps, also "
        "where it is missing. hed: an edge network, which finds the contours of objects in the colour image. canny: "
        "every strong change of colour.", _EDGES, choices=("rgbd", "hed", "canny"),
        source="section 2: HED and Canny; rgbd: not in the paper",
    )  # fmt: skip
    model: str = declare(
        BUNDLED, "Edge network", "The bundled network, or one of your own: 'ilf models import FILE'.", _EDGES,
        offers=model_names, source="section 2", when=_HED,
    )  # fmt: skip
    multiscale: bool = declare(
        False, "Three scales", "Let the network look at the image at three sizes: slightly better, 3.5 times as slow.",
        _EDGES, source="not in the paper", when=_HED,
    )  # fmt: skip
    threshold: float = declare(
        0.0, "Threshold", "Strength of the network's edges that counts as a boundary. 'auto' takes it from the image "
        "by Otsu's rule.", _EDGES, minimum=0.0, maximum=1.0, step=0.01, special="auto", source="section 2",
        when=_BY_NETWORK,
    )  # fmt: skip
    canny_sigma: float = declare(
        1.5, "Canny smoothing", "Gaussian blur of the colour image before Canny looks for edges, which lead the "
        "contraction of boundaries.", _EDGES,
        unit="px", minimum=0.0, maximum=10.0, step=0.1, source="section 2",
    )  # fmt: skip
    canny_high: float = declare(
        0.0, "Canny threshold", "Gradient above which an edge starts, as a share of the strongest. "
        "'auto' takes it from the image by Otsu's rule.", _EDGES,
        minimum=0.0, maximum=1.0, step=0.01, special="auto", source="section 2",
    )  # fmt: skip
    canny_low_ratio: float = declare(
        0.4, "Canny low / high", "An edge that has started goes on while the gradient is above this share "
        "of the threshold.", _EDGES, minimum=0.05, maximum=1.0, step=0.05, source="section 2",
    )  # fmt: skip
    use_depth: bool = declare(
        True, "Known depth counts", "Jumps of the known depth are boundaries, and neighbours whose depth goes on from "
        "one to the other merge.", _EDGES, source="section 2: EBS takes colour and depth",
    )  # fmt: skip
    depth_jump: float = declare(
        0.04, "Jump, at least", "Smallest difference between neighbours that counts as a depth jump.", _EDGES,
        unit="m", minimum=0.001, maximum=5.0, step=0.01, scale="log", when=_DEPTH,
    )  # fmt: skip
    depth_jump_share: float = declare(
        0.04, "Jump, share of depth", "The same, as a share of the depth itself; the larger of the two counts.",
        _EDGES, minimum=0.0, maximum=1.0, step=0.01, when=_DEPTH,
    )  # fmt: skip
    use_creases: bool = declare(
        False, "Creases are edges", "Where one plane meets another, as at the foot of a wall, is a boundary even "
        "without a change of colour.", _EDGES, source="not in the paper", when=_DEPTH,
    )  # fmt: skip
    dilation: int = declare(
        2, "Dilation", "Radius by which edges are dilated to close the gaps in boundaries.", _BOUNDARIES,
        unit="px", minimum=0, maximum=50, source="section 2",
    )  # fmt: skip
    margin: int = declare(
        -1, "Margin", "Width of the frame's rim that belongs to no block. 'auto' finds the white border "
        "of NYU images.", _BOUNDARIES, unit="px", minimum=-1, maximum=500, special="auto",
    )  # fmt: skip

    def smallest_block(self, pixels: int) -> float:
        """Pixels that a block has at least, in a frame of so many; at least 1."""
        return max(self.min_size / 100 * pixels, 1)


PAPER_BLOCKS = BlockParameters(detector="hed")
"""What blocks are extracted with for the presets of the paper, which knows contours of the colour image alone."""


@described
@dataclass(frozen=True)
class Parameters(ParameterSet):
    """Parameters of ILF, the iterative low-pass filter. Defaults are those of the preset `best`."""

    mode: str = declare(
        "fill", "Mode", "fill: only missing pixels change. fill+denoise: the whole block takes the filtered depth.",
        _OUTPUT, choices=("fill", "fill+denoise"), source="section 3; released code fills",
    )  # fmt: skip
    filter: str = declare(
        "edge-aware", "Low-pass filter", "ideal: everything up to a cut-off radius passes, nothing beyond, and the "
        "radius grows. edge-aware: what varies slowly passes, except at edges.", _OUTPUT,
        choices=("ideal", "edge-aware"),
        source="ideal: section 3; edge-aware: not in the paper",
    )  # fmt: skip
    smoothness: float = declare(
        1.0, "Smoothness", "How stiff the surface is: factor on the weights of slope and bending.", _SMOOTH,
        unit="x", minimum=0.001, maximum=1e6, step=0.1, source="not in the paper", scale="log", when=_EDGE_AWARE,
    )  # fmt: skip
    slope_weight: float = declare(
        0.03, "Weight of slope", "Of squared differences between neighbours, a known pixel having weight 1. It keeps "
        "large holes near the depth around them.", _SMOOTH, minimum=0.0, maximum=1e6, step=0.01,
        source="not in the paper", scale="log", when=_EDGE_AWARE,
    )  # fmt: skip
    bending_weight: float = declare(
        0.1, "Weight of bending", "Of squared second differences. It carries slopes on into holes.", _SMOOTH,
        minimum=0.0, maximum=1e6, step=0.1, source="not in the paper", scale="log", when=_EDGE_AWARE,
    )  # fmt: skip
    trend: bool = declare(
        True, "Follow the block's shape", "Take off the quadric surface that most of the block's known depth lies on, "
        "where there is one, and filter what is left.", _SMOOTH, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    noise: float = declare(
        0.0, "Noise", "Standard deviation of the known depth. 'auto' estimates it: to fill, in every block, to "
        "denoise, in the frame and by depth. The noisier, the less known pixels are followed one by one.", _SMOOTH,
        unit="m", scale="log", minimum=0.0, maximum=1.0, step=0.001, special="auto", source="not in the paper",
        when=_EDGE_AWARE,
    )  # fmt: skip
    jump_share: float = declare(
        0.005, "Jump, share of depth", "Bending above which the surface lets go, so that depth jumps and flying "
        "pixels do not pull at what is around them; where noise is taken off, the noise says instead. 0 switches it "
        "off.", _SMOOTH, scale="log", minimum=0.0, maximum=1.0,
        step=0.001, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    edges: str = declare(
        "combined", "Edges from", "rgbd: a network that looks at colour and known depth, and finds where depth jumps "
        "and where surfaces bend, also where depth is missing. combined: an edge network, which finds the contours of "
        "objects in the colour image. canny: every strong change of colour. Jumps of the known depth are edges with "
        "all of them.", _SOFT, choices=("rgbd", "combined", "canny"), when=_EDGE_AWARE,
        source="section 2: HED and Canny; rgbd: not in the paper",
    )  # fmt: skip
    model: str = declare(
        BUNDLED, "Edge network", "The bundled network, or one of your own: 'ilf models import FILE'.", _SOFT,
        offers=model_names, source="section 2", when=_COMBINED,
    )  # fmt: skip
    multiscale: bool = declare(
        False, "Three scales", "Let the network look at the image at three sizes: slightly better, 3.5 times as slow.",
        _SOFT, source="not in the paper", when=_COMBINED,
    )  # fmt: skip
    edge_scale: float = declare(
        0.14, "Edge strength that cuts", "Edge strength at which smoothness falls to 37 %; a smaller value makes faint "
        "edges count.", _SOFT, minimum=0.01, maximum=10.0, step=0.01, source="not in the paper", scale="log",
        when=_EDGE_AWARE,
    )  # fmt: skip
    boundary_strength: float = declare(
        0.3, "Strength of boundaries", "Edge strength that the block's own boundary has at least.", _SOFT,
        minimum=0.0, maximum=10.0, step=0.05, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    own_word: bool = declare(
        True, "A block's own word counts", "Around wide gaps, edges fade towards the block's own known depth alone: "
        "other blocks' depth helps as far as no edge parts them.", _SOFT, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    out_of_range: bool = declare(
        True, "Beyond the sensor's reach", "Where known depth rises to the frame's largest at a wide gap, what is "
        "missing is out of range: nothing in front pulls it near, and a note says so.", _SMOOTH,
        source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    trust_distance: float = declare(
        4.0, "Edges count in full from", "Distance to known depth from which on edges count in full; nearer, in "
        "proportion: among dense samples the depth itself says where the jumps are.", _SOFT,
        unit="px", minimum=0.1, maximum=100.0, step=0.5, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    correction: bool = declare(
        True, "Learned correction", "At the end a network looks at colour, known and completed depth and corrects what "
        "looks wrong to it, most of all on which surface a hole lies. Known depth stays, and so does what your edits "
        "have made of a block.", _OUTPUT, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    centred: bool = declare(
        True, "Subtract mean depth", "Filter the deviation from the mean known depth, so the hole need not be "
        "lifted from 0 m.", _OUTPUT, source="not in the paper", when=_IDEAL,
    )  # fmt: skip
    schedule: str = declare(
        "staged", "Schedule", "staged: enlarge the pass band whenever the iteration is steady. "
        "linear: enlarge it a little at every iteration.", _SCHEDULE,
        choices=("staged", "linear"), source="staged: text; linear: released code", when=_IDEAL,
    )  # fmt: skip
    staged_start: float = declare(
        0.0, "Staged start", "First cut-off frequency of the staged schedule, in basebands (1 / longest length of "
        "the block); 0 lets only the mean through.", _SCHEDULE,
        unit="basebands", minimum=0.0, maximum=50.0, step=0.5, source="not in the paper, which starts at 1",
        when=("schedule", "staged"),
    )  # fmt: skip
    stage_step: float = declare(
        0.5, "Stage step", "How much every stage of the staged schedule adds to the cut-off frequency.",
        _SCHEDULE, unit="basebands", scale="log", minimum=0.05, maximum=50.0, step=0.1,
        source="section 3; value not given", when=("schedule", "staged"),
    )  # fmt: skip
    linear_start: float = declare(
        0.5, "Linear start", "First radius of the linear schedule, in cycles per side of the block.", _SCHEDULE,
        unit="cycles", scale="log", minimum=0.0, maximum=50.0, step=0.1, source="released code",
        when=("schedule", "linear"),
    )  # fmt: skip
    shortest_wavelength: float = declare(
        15.0, "Shortest wavelength", "Where the pass band stops growing: the shortest wave it lets through.",
        _SCHEDULE, unit="px", scale="log", minimum=2.0, maximum=2000.0, source="released code", when=_IDEAL,
    )  # fmt: skip
    padding: float = declare(
        2.0, "Padding", "Side of the zero-padded grid, in sides of the block's bounding box.", _SCHEDULE,
        unit="x", minimum=1.0, maximum=4.0, step=0.25, source="section 3", when=_IDEAL,
    )  # fmt: skip
    s_criteria: float = declare(
        0.0005, "S_criteria", "The iteration is steady when sigma_i falls below this. Stages of the edge-aware "
        "filter also end by a number of steps.", _STOP,
        unit="m", scale="log", minimum=0.0, maximum=1.0, step=0.001, source="Eq. (1)",
    )  # fmt: skip
    stop_when_steady: bool = declare(
        True, "Stop when steady", "Stop as soon as the iteration is steady and the pass band has reached its last "
        "radius; otherwise always run all iterations.", _STOP, source="Eq. (1); released code: off", when=_IDEAL,
    )  # fmt: skip
    max_iterations: int = declare(
        1500, "Iterations, at most", "Upper limit of the iteration count; the linear schedule reaches its last "
        "radius there.", _STOP, scale="log", minimum=1, maximum=100_000, step=100, source="section 3",
    )  # fmt: skip
    validation_share: float = declare(
        0.0, "Validation share", "Share of the known pixels that the iteration does not see, to judge it by: noise "
        "comes in as the filter lets more through, and sigma_i does not tell. The minimum of the hold-out curve says "
        "where to stop.", _STOP, minimum=0.0, maximum=0.5, step=0.01, source="not in the paper",
    )  # fmt: skip
    rgb_iterations: int = declare(
        150, "Colour-weighted iterations", "For so many iterations the block's colour spectrum weights the filter; "
        "0 switches it off.", _COLOUR, scale="log", minimum=0, maximum=100_000, step=10,
        source="section 3: at most 150", when=_IDEAL,
    )  # fmt: skip
    rgb_dilation: int = declare(
        3, "Spectrum dilation", "Radius of the disk that dilates the colour spectrum.", _COLOUR,
        unit="samples", minimum=0, maximum=50, source="released code", when=_IDEAL,
    )  # fmt: skip
    precision: str = declare(
        "float64", "Precision", "Of the iteration's arithmetic. float32 is faster; its depth differs by tenths of a "
        "millimetre.",
        _OUTPUT, choices=("float64", "float32"), source="not in the paper", when=_IDEAL,
    )  # fmt: skip
    min_known_share: float = declare(
        0.02, "Known share, at least", "A block with a smaller share of known depth is reported as not recoverable "
        "and stays missing.", _DATA, minimum=0.0, maximum=1.0, step=0.01,
    )  # fmt: skip
    outside_view: bool = declare(
        False, "Fill outside the view", "Fill also what the depth camera could not see, because it lies outside its "
        "picture: nothing was measured there, or could have been. Otherwise it stays missing.", _DATA,
        source="not in the paper",
    )  # fmt: skip
    min_known_pixels: int = declare(
        30, "Known pixels, at least", "A block with fewer known pixels is reported as not recoverable and stays "
        "missing.", _DATA, unit="px", scale="log", minimum=1, maximum=1_000_000,
    )  # fmt: skip


_PAPER: dict[str, Any] = {
    "filter": "ideal", "centred": False, "s_criteria": 0.005, "edges": "combined",
    "own_word": False, "out_of_range": False, "correction": False,
}  # fmt: skip
"""What the paper's text has otherwise than `best`, and the released code, too."""

PRESETS: dict[str, Parameters] = {
    "best": Parameters(),
    "paper": Parameters(**_PAPER),
    "released-code": Parameters(**_PAPER, schedule="linear", stop_when_steady=False, rgb_iterations=99),
}
"""Name -> parameters: `best` follows measurements, `paper` the text, `released-code` the authors' MATLAB program."""

DEFAULT_PRESET = "best"


def as_parameters(given: Parameters | str | None, /, **changes: object) -> Parameters:
    """Parameters of the filter that a caller gives, or names by a preset, with any of them changed by keyword.

    Parameters
    ----------
    given : Parameters, str or None
        A text is the name of a preset; None stands for the default preset.
    **changes
        Any parameter by name.

    Raises
    ------
    ParameterError
        For an unknown preset or parameter, a value out of range, a parameter that has no effect beside the others, or
        anything but parameters.

    Examples
    --------
    >>> as_parameters("paper") == preset("paper")
    True
    >>> as_parameters(Parameters(trend=False), noise=0.01).noise
    0.01
    """
    if given is None or isinstance(given, str):
        return preset(DEFAULT_PRESET if given is None else given, **changes)
    if isinstance(given, Parameters):
        return given.changed(**changes)
    raise ParameterError(
        f"Parameters must be ilf.Parameters or the name of a preset ({', '.join(PRESETS)}), not {given!r:.60}."
    )


def as_extraction(given: BlockParameters | None, /, **changes: object) -> BlockParameters:
    """Parameters of the extraction that a caller gives, the defaults for None, with any of them changed by keyword; or
    ParameterError."""
    if given is None or isinstance(given, BlockParameters):
        return (given or BlockParameters()).changed(**changes)
    raise ParameterError(
        f"Blocks are extracted with ilf.BlockParameters, not {given!r:.60}. Parameters and presets of the filter are "
        "given as preset=."
    )


def by_set(changes: Mapping[str, Value], *others: str) -> tuple[dict[str, Value], dict[str, Value]]:
    """Parameters that a caller gives by keyword: those of the filter, and those of the extraction.

    Names that both have are the filter's.

    Parameters
    ----------
    changes : mapping
        Name -> value.
    *others : str
        Further keywords of the call, which a misspelt name may be meant for.

    Raises
    ------
    ParameterError
        For a name that neither has, with the nearest known one.

    Examples
    --------
    >>> by_set({"noise": 0.01, "granularity": 0.3, "model": "edges"})
    ({'noise': 0.01, 'model': 'edges'}, {'granularity': 0.3})
    """
    of_filter = Parameters.declarations()
    check_names(changes, [*of_filter, *BlockParameters.declarations(), *others])
    first = {name: value for name, value in changes.items() if name in of_filter}
    return first, {name: value for name, value in changes.items() if name not in of_filter}


def preset(name: str = DEFAULT_PRESET, **changes: object) -> Parameters:
    """Parameters by preset name, with any of them changed.

    Parameters
    ----------
    name : str
        "best" (edge-aware filter), "paper" (staged schedule, stop when steady) or "released-code" (linear schedule,
        always 1500 iterations).
    **changes
        Any parameter by name.

    Raises
    ------
    ParameterError
        For an unknown preset or parameter, a value out of range, or a parameter that has no effect beside the others.

    Examples
    --------
    >>> preset() == Parameters()
    True
    >>> preset("released-code", rgb_iterations=0, mode="fill+denoise").rgb_iterations
    0
    >>> preset("best", padding=3)
    Traceback (most recent call last):
    ilf.errors.ParameterError: padding has no effect with filter edge-aware; it belongs to filter ideal.
    """
    if name not in PRESETS:
        raise ParameterError(f"There is no preset {name!r}. Known: {', '.join(PRESETS)}.")
    return PRESETS[name].changed(**changes)


# What parameters are in few words: the preset that they are nearest to, and what differs from it.


@dataclass(frozen=True)
class Likeness:
    """How parameters stand to the preset that they are nearest to.

    Attributes
    ----------
    preset : str
        Its name.
    differs : mapping of str to value
        The values that differ from it and have an effect, by name, in the order of the form.
    """

    preset: str
    differs: Mapping[str, Value]

    def text(self, most: int | None = None) -> str:
        """In words: the preset's name and the values that differ, `most` of them at most.

        Examples
        --------
        >>> from ilf import preset
        >>> likeness(preset(smoothness=0.6, trend=False)).text()
        "best, smoothness 0.6 x, follow the block's shape off"
        >>> likeness(preset(smoothness=0.6, trend=False)).text(most=1)
        'best, smoothness 0.6 x, and 1 more'
        """
        return ", ".join([self.preset, *in_words(self.differs, most)])


def in_words(values: Mapping[str, Value], most: int | None = None) -> list[str]:
    """Values of the filter as people write them, `most` of them at most and how many more there are.

    Examples
    --------
    >>> in_words({"noise": 0.004, "trend": False})
    ['noise 0.004 m', "follow the block's shape off"]
    """
    declarations = Parameters.declarations()
    words = [
        f"{_in_a_list(declarations[name].label)} {declarations[name].in_words(value)}" for name, value in values.items()
    ]
    if most is None or len(words) <= most:
        return words
    return [*words[:most], f"and {len(words) - most} more"]


def likeness(parameters: Parameters, presets: Mapping[str, Parameters] = PRESETS) -> Likeness:
    """The preset that parameters are nearest to, which is the one that fewest values differ from.

    Parameters
    ----------
    parameters : Parameters
    presets : mapping of str to Parameters
        Name -> values; of several that are as near, the first counts.

    Examples
    --------
    >>> from ilf import preset
    >>> likeness(preset("paper", mode="fill+denoise"))
    Likeness(preset='paper', differs={'mode': 'fill+denoise'})
    """
    found = [Likeness(name, _differing(parameters, values)) for name, values in presets.items()]
    return min(found, key=lambda one: len(one.differs))


def _differing(parameters: Parameters, others: Parameters) -> dict[str, Value]:
    return {name: value for name, value in parameters.unlike(others).items() if parameters.matters(name)}


def _in_a_list(label: str) -> str:
    """A label as it stands within a list; symbols, such as S_criteria, stay as they are."""
    label = label.replace(",", "")
    return label[:1].lower() + label[1:] if label[1:2].islower() else label

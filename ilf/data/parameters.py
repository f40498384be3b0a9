"""The parameters of EBS and of ILF, and the presets. Plain data without computation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .._runtime.networks.models import BUNDLED, model_names
from ..errors import ParameterError
from .declarations import ParameterSet, Value, check_names, declare, with_documented_parameters

_BLOCKS, _EDGES, _BOUNDARIES = "Blocks", "Edges", "Boundaries"
_OUTPUT, _SCHEDULE, _STOP, _COLOUR, _DATA = "Output", "Pass band", "Stopping", "Colour", "Data"
_SMOOTH, _SOFT = "Smoothness", "Edges"
_BY_NETWORK, _HED, _DEPTH = ("detector", "rgbd", "hed"), ("detector", "hed"), ("use_depth", True)
_COMBINED = ("edges", "combined")
_IDEAL, _EDGE_AWARE = ("filter", "ideal"), ("filter", "edge-aware")


@with_documented_parameters
@dataclass(frozen=True)
class BlockParameters(ParameterSet):
    """Parameters of EBS, the extraction of boundaries and surfaces. Lengths in pixels of the frame.

    Examples
    --------
    >>> BlockParameters(granularity=0.3).changed(min_size=2).min_size
    2.0
    """

    granularity: float = declare(
        0.5, "Granularity", "0: few large blocks, divided only by depth jumps and the strongest edges. 1: many small "
        "blocks.", _BLOCKS, minimum=0.0, maximum=1.0, step=0.05, source="not in the paper", basic=True,
    )  # fmt: skip
    min_size: float = declare(
        0.5, "Smallest block", "Regions below this share (a fifth of it between depth jumps) are "
        "merged with their neighbours.", _BLOCKS,
        unit="% of frame", minimum=0.0, maximum=50.0, step=0.1, scale="log", source="section 2; released code: 1.14 %",
        basic=True,
    )  # fmt: skip
    min_known_share: float = declare(
        0.05, "Min. known fraction", "Regions with a smaller fraction of pixels with depth are merged with their "
        "neighbours.", _BLOCKS, minimum=0.0, maximum=1.0, step=0.01,
        source="section 2",
    )  # fmt: skip
    existence_rate: float = declare(
        0.0, "Existence rate", "Blocks with a smaller share of pixels with depth are halved, up to twice, and only the "
        "parts that reach this rate are kept. The rest belongs to no block and stays missing.", _BLOCKS,
        minimum=0.0, maximum=1.0, step=0.01, special="off", source="section 2; released code: 0.52",
    )  # fmt: skip
    detector: str = declare(
        "hed", "Edge detector", "rgbd: a network that finds depth jumps from colour and known depth, also where depth "
        "is missing. hed: an edge network that finds the contours of objects in the colour image. canny: every strong "
        "colour gradient.", _EDGES, choices=("rgbd", "hed", "canny"),
        source="section 2: HED and Canny; rgbd: not in the paper", basic=True,
    )  # fmt: skip
    model: str = declare(
        BUNDLED, "Edge network", "The bundled network, or one of your own: 'ilf models add FILE'.", _EDGES,
        offers=model_names, source="section 2", when=_HED,
    )  # fmt: skip
    multiscale: bool = declare(
        False, "Three scales", "Run the network on the image at three scales: slightly better, 3.5 times as slow.",
        _EDGES, source="not in the paper", when=_HED,
    )  # fmt: skip
    threshold: float = declare(
        0.0, "Threshold", "Minimum strength of the network's edges that counts as a boundary. 'auto' derives it from "
        "the image by Otsu's method.", _EDGES, minimum=0.0, maximum=1.0, step=0.01, special="auto", source="section 2",
        when=_BY_NETWORK,
    )  # fmt: skip
    canny_sigma: float = declare(
        1.5, "Canny smoothing", "Gaussian blur of the colour image before Canny edge detection; these edges guide the "
        "contraction of boundaries.", _EDGES,
        unit="px", minimum=0.0, maximum=10.0, step=0.1, source="section 2",
    )  # fmt: skip
    canny_high: float = declare(
        0.0, "Canny threshold", "Gradient above which an edge starts, as a share of the largest. "
        "'auto' derives it from the image by Otsu's method.", _EDGES,
        minimum=0.0, maximum=1.0, step=0.01, special="auto", source="section 2",
    )  # fmt: skip
    canny_low_ratio: float = declare(
        0.4, "Canny low / high", "An edge continues while the gradient is above this share "
        "of the threshold.", _EDGES, minimum=0.05, maximum=1.0, step=0.05, source="section 2",
    )  # fmt: skip
    use_depth: bool = declare(
        True, "Use known depth", "Jumps of the known depth are boundaries, and neighbouring regions with continuous "
        "depth are merged.", _EDGES, source="section 2: EBS takes colour and depth", basic=True,
    )  # fmt: skip
    depth_jump: float = declare(
        0.04, "Min. depth jump", "Minimum difference between neighbours that counts as a depth jump.", _EDGES,
        unit="m", minimum=0.001, maximum=5.0, step=0.01, scale="log", when=_DEPTH, basic=True,
    )  # fmt: skip
    depth_jump_share: float = declare(
        0.04, "Min. relative jump", "The same, as a share of the depth itself; the larger of the two applies.",
        _EDGES, minimum=0.0, maximum=1.0, step=0.01, when=_DEPTH,
    )  # fmt: skip
    use_creases: bool = declare(
        False, "Use creases", "Lines where one plane meets another, as at the foot of a wall, are boundaries even "
        "without a change of colour.", _EDGES, source="not in the paper", when=_DEPTH,
    )  # fmt: skip
    dilation: int = declare(
        2, "Dilation", "Radius by which edges are dilated to close gaps in boundaries.", _BOUNDARIES,
        unit="px", minimum=0, maximum=50, source="section 2", basic=True,
    )  # fmt: skip
    margin: int = declare(
        -1, "Margin", "Width of the frame's rim that belongs to no block. 'auto' detects the white border "
        "of NYU images.", _BOUNDARIES, unit="px", minimum=-1, maximum=500, special="auto",
    )  # fmt: skip

    def smallest_block(self, pixels: int) -> float:
        """Return the minimum number of pixels of a block in a frame of this many pixels; at least 1."""
        return max(self.min_size / 100 * pixels, 1)


PAPER_BLOCKS = BlockParameters(detector="hed")
"""Extraction parameters for the presets of the paper, which uses only contours of the colour image."""


@with_documented_parameters
@dataclass(frozen=True)
class Parameters(ParameterSet):
    """Parameters of ILF, the iterative low-pass filter. The defaults are those of the preset `best`.

    Examples
    --------
    >>> Parameters(smoothness=2).differences_from(Parameters())
    {'smoothness': 2.0}
    """

    mode: str = declare(
        "fill", "Mode", "fill: only missing pixels change. fill+denoise: the whole block gets the filtered depth.",
        _OUTPUT, choices=("fill", "fill+denoise"), source="section 3; released code fills", basic=True,
    )  # fmt: skip
    filter: str = declare(
        "edge-aware", "Low-pass filter", "ideal: passes all frequencies up to a growing cut-off radius, and none "
        "beyond. edge-aware: passes slow variations, except at edges.", _OUTPUT,
        choices=("ideal", "edge-aware"),
        source="ideal: section 3; edge-aware: not in the paper",
    )  # fmt: skip
    smoothness: float = declare(
        1.0, "Smoothness", "Stiffness of the surface: factor on the slope weight and the bending weight. Where depth "
        "is missing, the surface follows from the ratio of the two, so that the factor acts little when only filling.",
        _SMOOTH, unit="x", minimum=0.001, maximum=1e6, step=0.1, source="not in the paper", scale="log",
        when=_EDGE_AWARE,
    )  # fmt: skip
    slope_weight: float = declare(
        0.03, "Slope weight", "Weight of squared differences between neighbours; a known pixel has weight 1. It keeps "
        "large holes near the depth around them.", _SMOOTH, minimum=0.0, maximum=1e6, step=0.01,
        source="not in the paper", scale="log", when=_EDGE_AWARE, basic=True,
    )  # fmt: skip
    bending_weight: float = declare(
        0.1, "Bending weight", "Weight of squared second differences. It continues slopes into holes.", _SMOOTH,
        minimum=0.0, maximum=1e6, step=0.1, source="not in the paper", scale="log", when=_EDGE_AWARE,
    )  # fmt: skip
    trend: bool = declare(
        True, "Subtract trend", "Subtract the plane or quadric that most of the block's known depth lies on, if there "
        "is one, and filter the residual.", _SMOOTH, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    noise: float = declare(
        0.0, "Noise", "Standard deviation of the known depth. 'auto' estimates it: for fill, in every block; for "
        "denoise, in the frame and by depth. More noise means less weight for single known pixels.", _SMOOTH,
        unit="m", scale="log", minimum=0.0, maximum=1.0, step=0.001, special="auto", source="not in the paper",
        when=_EDGE_AWARE, basic=True,
    )  # fmt: skip
    jump_share: float = declare(
        0.005, "Relative jump threshold", "Bending, as a share of depth, above which the surface is cut, so that depth "
        "jumps and flying pixels do not affect their surroundings; when denoising, the noise sets the threshold. 0 "
        "turns it off.", _SMOOTH, scale="log", minimum=0.0, maximum=1.0,
        step=0.001, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    edges: str = declare(
        "combined", "Edge detector", "rgbd: a network that finds depth jumps and bends of surfaces from colour and "
        "known depth, also where depth is missing. combined: an edge network that finds the contours of objects in the "
        "colour image. canny: every strong colour gradient. Jumps of the known depth are edges with all three.",
        _SOFT, choices=("rgbd", "combined", "canny"), when=_EDGE_AWARE,
        source="section 2: HED and Canny; rgbd: not in the paper", basic=True,
    )  # fmt: skip
    model: str = declare(
        BUNDLED, "Edge network", "The bundled network, or one of your own: 'ilf models add FILE'.", _SOFT,
        offers=model_names, source="section 2", when=_COMBINED,
    )  # fmt: skip
    multiscale: bool = declare(
        False, "Three scales", "Run the network on the image at three scales: slightly better, 3.5 times as slow.",
        _SOFT, source="not in the paper", when=_COMBINED,
    )  # fmt: skip
    edge_scale: float = declare(
        0.14, "Edge cut-off", "Edge strength at which smoothness falls to 37 %; a smaller value includes fainter "
        "edges.", _SOFT, minimum=0.01, maximum=10.0, step=0.01, source="not in the paper", scale="log",
        when=_EDGE_AWARE, basic=True,
    )  # fmt: skip
    boundary_strength: float = declare(
        0.3, "Boundary strength", "Minimum edge strength of the block's own boundary.", _SOFT,
        minimum=0.0, maximum=10.0, step=0.05, source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    block_local_edges: bool = declare(
        True, "Block's own depth at wide gaps", "Around wide gaps, edges fade only towards the block's own "
        "known depth: depth of other blocks is used only where no edge lies in between.", _SOFT,
        source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    out_of_range: bool = declare(
        True, "Beyond sensor range", "Where known depth at a wide gap rises to the frame's maximum, the missing depth "
        "is out of sensor range: closer surfaces do not affect it, and a note reports it.", _SMOOTH,
        source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    trust_distance: float = declare(
        4.0, "Full edge weight above", "Distance to known depth above which edges have full weight; below, the weight "
        "is proportional to it: where samples are dense, the depth itself shows the jumps.", _SOFT,
        unit="px", minimum=0.1, maximum=100.0, step=0.5, scale="log", source="not in the paper", when=_EDGE_AWARE,
    )  # fmt: skip
    correction: bool = declare(
        True, "Learned correction", "At the end, a network corrects completed depth from colour, known and completed "
        "depth, mainly which surface a hole lies on. Known depth stays, and so do the effects of your edits on a "
        "block.", _OUTPUT, source="not in the paper", when=_EDGE_AWARE, basic=True,
    )  # fmt: skip
    centred: bool = declare(
        True, "Subtract mean depth", "Filter the deviation from the mean known depth, so that holes do not start at "
        "0 m.", _OUTPUT, source="not in the paper", when=_IDEAL,
    )  # fmt: skip
    schedule: str = declare(
        "staged", "Schedule", "staged: enlarge the pass band whenever the iteration is steady. "
        "linear: enlarge it slightly at every iteration.", _SCHEDULE,
        choices=("staged", "linear"), source="staged: text; linear: released code", when=_IDEAL, basic=True,
    )  # fmt: skip
    staged_start: float = declare(
        0.0, "Staged start", "First cut-off frequency of the staged schedule, in basebands (1 / longest length of "
        "the block); 0 passes only the mean.", _SCHEDULE,
        unit="basebands", minimum=0.0, maximum=50.0, step=0.5, source="not in the paper, which starts at 1",
        when=("schedule", "staged"),
    )  # fmt: skip
    stage_step: float = declare(
        0.5, "Stage step", "Increase of the cut-off frequency per stage of the staged schedule.",
        _SCHEDULE, unit="basebands", scale="log", minimum=0.05, maximum=50.0, step=0.1,
        source="section 3; value not given", when=("schedule", "staged"), basic=True,
    )  # fmt: skip
    linear_start: float = declare(
        0.5, "Linear start", "First radius of the linear schedule, in cycles per side of the block.", _SCHEDULE,
        unit="cycles", scale="log", minimum=0.0, maximum=50.0, step=0.1, source="released code",
        when=("schedule", "linear"), basic=True,
    )  # fmt: skip
    shortest_wavelength: float = declare(
        15.0, "Shortest wavelength", "Final limit of the pass band: the shortest wavelength that it passes.",
        _SCHEDULE, unit="px", scale="log", minimum=2.0, maximum=2000.0, source="released code", when=_IDEAL,
        basic=True,
    )  # fmt: skip
    padding: float = declare(
        2.0, "Padding", "Side of the zero-padded grid, as a multiple of the block's bounding box.", _SCHEDULE,
        unit="x", minimum=1.0, maximum=4.0, step=0.25, source="section 3", when=_IDEAL,
    )  # fmt: skip
    s_criteria: float = declare(
        0.0005, "S_criteria", "The iteration is steady when sigma_i falls below this. Stages of the edge-aware "
        "filter also end at a step limit.", _STOP,
        unit="m", scale="log", minimum=0.0, maximum=1.0, step=0.001, source="Eq. (1)",
    )  # fmt: skip
    stop_when_steady: bool = declare(
        True, "Stop when steady", "Stop as soon as the iteration is steady and the pass band has reached its last "
        "radius; otherwise always run all iterations.", _STOP, source="Eq. (1); released code: off", when=_IDEAL,
        basic=True,
    )  # fmt: skip
    max_iterations: int = declare(
        1500, "Max. iterations", "Maximum number of iterations; the linear schedule reaches its last "
        "radius there.", _STOP, scale="log", minimum=1, maximum=100_000, step=100, source="section 3",
    )  # fmt: skip
    validation_share: float = declare(
        0.0, "Hold-out share", "Share of the known pixels withheld from the iteration to evaluate it: noise enters as "
        "the pass band grows, and sigma_i does not show this. The minimum of the hold-out curve shows where to stop.",
        _STOP, minimum=0.0, maximum=0.5, step=0.01, source="not in the paper",
    )  # fmt: skip
    rgb_iterations: int = declare(
        150, "Colour-weighted iterations", "Number of iterations in which the block's colour spectrum weights the "
        "filter; 0 turns it off.", _COLOUR, scale="log", minimum=0, maximum=100_000, step=10,
        source="section 3: at most 150", when=_IDEAL, basic=True,
    )  # fmt: skip
    rgb_dilation: int = declare(
        3, "Spectrum dilation", "Radius of the disk that dilates the colour spectrum.", _COLOUR,
        unit="samples", minimum=0, maximum=50, source="released code", when=_IDEAL,
    )  # fmt: skip
    precision: str = declare(
        "float64", "Precision", "Precision of the iteration's arithmetic. float32 is faster; its depth differs by "
        "tenths of a millimetre.",
        _OUTPUT, choices=("float64", "float32"), source="not in the paper", when=_IDEAL,
    )  # fmt: skip
    min_known_share: float = declare(
        0.02, "Min. known fraction", "A block with a smaller fraction of known depth is reported as not recoverable "
        "and stays missing.", _DATA, minimum=0.0, maximum=1.0, step=0.01,
    )  # fmt: skip
    outside_view: bool = declare(
        False, "Fill outside the view", "Also fill pixels outside the depth camera's view, where nothing could be "
        "measured. Otherwise they stay missing.", _DATA,
        source="not in the paper",
    )  # fmt: skip
    min_known_pixels: int = declare(
        30, "Min. known pixels", "A block with fewer known pixels is reported as not recoverable and stays "
        "missing.", _DATA, unit="px", scale="log", minimum=1, maximum=1_000_000,
    )  # fmt: skip


_PAPER: dict[str, Any] = {
    "filter": "ideal", "centred": False, "s_criteria": 0.005, "edges": "combined",
    "block_local_edges": False, "out_of_range": False, "correction": False,
}  # fmt: skip
"""Values in which both the paper's text and the released code differ from `best`."""

PRESETS: dict[str, Parameters] = {
    "best": Parameters(),
    "paper": Parameters(**_PAPER),
    "released-code": Parameters(**_PAPER, schedule="linear", stop_when_steady=False, rgb_iterations=99),
}
"""Name -> parameters: `best` by measurements, `paper` as in its text, `released-code` as the authors' MATLAB code."""

DEFAULT_PRESET = "best"


def as_block_parameters(given: BlockParameters | None, /, **changes: object) -> BlockParameters:
    """Return extraction parameters, the defaults for None, with any of them changed by keyword; raise ParameterError
    for other types."""
    if given is None or isinstance(given, BlockParameters):
        return (given or BlockParameters()).changed(**changes)
    raise ParameterError(
        f"Parameters of the extraction must be ilf.BlockParameters, not {given!r:.60}. Give parameters and presets of "
        "the filter as preset=."
    )


def split_parameters(changes: Mapping[str, Value], *others: str) -> tuple[dict[str, Value], dict[str, Value]]:
    """Split parameters given by keyword into those of the filter and those of the extraction.

    Names that both have belong to the filter.

    Parameters
    ----------
    changes : mapping
        Name -> value.
    *others : str
        Further keywords of the call, suggested for misspelt names.

    Raises
    ------
    ParameterError
        For an unknown name, with the nearest known one.

    Examples
    --------
    >>> split_parameters({"noise": 0.01, "granularity": 0.3, "model": "edges"})
    ({'noise': 0.01, 'model': 'edges'}, {'granularity': 0.3})
    """
    of_filter = Parameters.declarations()
    check_names(changes, [*of_filter, *BlockParameters.declarations(), *others])
    first = {name: value for name, value in changes.items() if name in of_filter}
    return first, {name: value for name, value in changes.items() if name not in of_filter}


# Short description of parameters: the nearest preset, and the values that differ from it.


@dataclass(frozen=True)
class NearestPreset:
    """Nearest preset of parameters, and the values that differ from it.

    Attributes
    ----------
    preset : str
        Name of the preset.
    differs : mapping of str to value
        The values that differ from it and have an effect, by name, in the order of the form.
    """

    preset: str
    differs: Mapping[str, Value]

    def text(self, most: int | None = None) -> str:
        """Format the preset's name and at most `most` of the values that differ.

        Examples
        --------
        >>> from ilf import preset
        >>> nearest_preset(preset(smoothness=0.6, trend=False)).text()
        'best, smoothness 0.6 x, subtract trend off'
        >>> nearest_preset(preset(smoothness=0.6, trend=False)).text(most=1)
        'best, smoothness 0.6 x, and 1 more'
        """
        return ", ".join([self.preset, *to_text(self.differs, most)])


def to_text(values: Mapping[str, Value], most: int | None = None) -> list[str]:
    """Format values of the filter as text: at most `most` of them, and the number of the others.

    Examples
    --------
    >>> to_text({"noise": 0.004, "trend": False})
    ['noise 0.004 m', 'subtract trend off']
    """
    declarations = Parameters.declarations()
    words = [
        f"{_in_a_list(declarations[name].label)} {declarations[name].to_text(value)}" for name, value in values.items()
    ]
    if most is None or len(words) <= most:
        return words
    return [*words[:most], f"and {len(words) - most} more"]


def nearest_preset(parameters: Parameters, presets: Mapping[str, Parameters] = PRESETS) -> NearestPreset:
    """Find the nearest preset of parameters: the one with the fewest differing values.

    Parameters
    ----------
    parameters : Parameters
    presets : mapping of str to Parameters
        Name -> values; of several equally near, the first is taken.

    Examples
    --------
    >>> from ilf import preset
    >>> nearest_preset(preset("paper", mode="fill+denoise"))
    NearestPreset(preset='paper', differs={'mode': 'fill+denoise'})
    """
    differences = ((preset, parameters.differences_from(values).items()) for preset, values in presets.items())
    found = (
        NearestPreset(preset, {name: value for name, value in differing if parameters.has_effect(name)})
        for preset, differing in differences
    )
    return min(found, key=lambda one: len(one.differs))


def _in_a_list(label: str) -> str:
    """Format a label for use within a list; symbols, such as S_criteria, stay unchanged."""
    label = label.replace(",", "")
    return label[:1].lower() + label[1:] if label[1:2].islower() else label

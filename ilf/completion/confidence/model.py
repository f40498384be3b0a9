"""The model of the expected error, and what it uses: a filled pixel's depth compared with the known depth around it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import compiled
from ..._runtime.long_work import check_cancelled
from ...data.arrays import check_shape
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.parameters import BlockParameters, Parameters
from ...data.pixel_grids import nearest_values, padded, sums_of_four
from ...errors import InstallationError
from ...segmentation.edges.frame_edges import FrameEdges, edge_parameters, find_edges
from ..banded import solve_linked

Array = NDArray[np.float32]

# Random walks from every pixel: they hardly cross edges, and end at known depth.
#
# Where consistent known depth surrounds a pixel, walks are short and end at one depth. In a wide hole they are long;
# between a far surface and a near one they end at either; enclosed by edges they hardly end at all.

_CELLS = 6000
"""Maximum number of cells in the grid of the walks; cells are 2, 4, 8, ... px wide."""

_EDGE_SCALE = 0.13
"""Increase of edge strength by which a step becomes e times less likely."""

_LEAST = 1e-4
"""Minimum probability of a step across an edge, and probability of ending at any step: walks have at most the inverse
number of steps."""


@dataclass(frozen=True, eq=False)
class Walks:
    """Statistics of the walks from every pixel.

    Attributes
    ----------
    cells : ndarray of float32, shape (4, rows, columns)
        Values at the cells: `depth`, `spread`, `steps` and `aside`, in this order. The properties resample them to the
        frame's size.
    cell : int
        Side of a cell [px].
    shape : (int, int)
        Height and width of the frame [px].
    """

    cells: Array
    cell: int
    shape: tuple[int, int]

    @property
    def depth(self) -> Array:
        """Mean of the logarithm of the depth [m] at which they end, (H, W)."""
        return self._on_pixels(0)

    @property
    def spread(self) -> Array:
        """Standard deviation of that logarithm, (H, W)."""
        return self._on_pixels(1)

    @property
    def steps(self) -> Array:
        """Their length in steps of one cell, (H, W)."""
        return self._on_pixels(2)

    @property
    def aside(self) -> Array:
        """Distance [px] of the mean of their end points from their start, (H, W): small in the middle of known depth,
        large where it lies on one side only."""
        return self._on_pixels(3)

    def in_cells(self, cell: int) -> Walks:
        """The same in a frame scaled down, by squares of so many pixels: a power of 2 that is no more than `cell`."""
        height, width = (-(-size // cell) for size in self.shape)
        apart = np.array([1, 1, 1, 1 / cell], np.float32)[:, None, None]
        return Walks(self.cells * apart, self.cell // cell, (height, width))

    def _on_pixels(self, number: int) -> Array:
        """Resample values of the cells to the pixels, bilinearly."""
        values, (height, width) = self.cells[number], self.shape
        size = values.shape[1] * self.cell, values.shape[0] * self.cell
        full = cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(full[:height, :width], np.float32)


def walk(depth: Array, edges: Array) -> Walks:
    """Compute the walks in a frame with some known depth [m], NaN = missing, and edge strength in [0, 1]."""
    cell = 2
    while -(-depth.shape[0] // cell) * -(-depth.shape[1] // cell) > _CELLS:
        cell *= 2
    known = np.isfinite(depth)
    logarithm = np.log(depth, where=known, out=np.zeros_like(depth))
    middle = np.float32(logarithm.sum(dtype=np.float64) / np.count_nonzero(known))
    np.subtract(logarithm, middle, out=logarithm, where=known)
    counts = _sums(known.astype(np.float32), cell)
    mean, square = (_sums(values, cell) / np.maximum(counts, 1) for values in (logarithm, logarithm * logarithm))
    rows, columns = np.indices(counts.shape)
    # in a cell full of known depth, a walk is more likely to end than to leave
    ends = (counts / cell).astype(np.float64)
    hard = edges / np.float32(-_EDGE_SCALE)
    np.maximum(np.exp(hard, out=hard), np.float32(_LEAST), out=hard)
    np.reciprocal(hard, out=hard)
    along_x, along_y = _links(hard, cell), _links(np.ascontiguousarray(hard.T), cell).T
    wanted = np.stack([ends, np.ones_like(ends), *(ends * values for values in (mean, square, rows, columns))])
    # for the walks from every cell, the sums of the values collected at each step
    arriving, steps, *gathered = solve_linked(along_x, along_y, ends + _LEAST, wanted)
    mean_end, square_end, row_end, column_end = (values / np.maximum(arriving, 1e-12) for values in gathered)
    spread = np.sqrt(np.maximum(square_end - mean_end**2, 0))
    aside = cell * np.hypot(row_end - rows, column_end - columns)
    height, width = depth.shape
    return Walks(np.stack([mean_end + middle, spread, steps, aside]).astype(np.float32), cell, (height, width))


def _sums(values: NDArray, cell: int) -> Array:
    """Sums over cells, float32 (rows of cells, columns of cells)."""
    return _means(padded(values, cell), cell, cell) * np.float32(cell * cell)


def _links(hard: Array, cell: int) -> Array:
    """Conductance from a cell's centre to the next along x: parallel paths, each as resistive as its pixels."""
    whole = padded(hard, cell, "edge")
    after = cell // 2 + 1
    between = whole[:, after : whole.shape[1] - cell + after]
    if not between.size:
        return np.empty((whole.shape[0] // cell, 0), np.float32)
    return _means(1 / _means(between, cell, 1), 1, cell)


def _means(values: NDArray, width: int, height: int) -> Array:
    """Means over rectangles of width x height pixels, which divide the array evenly."""
    size = values.shape[1] // width, values.shape[0] // height
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float32)


# Features of filled pixels, from the walks, the known depth around and the edges.

FLOOR = 1e-4
"""Minimum expected error, as a share of depth; also keeps the logarithms of jumps and bends finite."""

FEATURES = {
    "depth": "the depth itself [m]",
    "gap": "width of the gap: the largest distance to known depth nearby [px of a frame 640 px wide]",
    "bend": "deviation of the known depth from a plane over that distance, as a share of depth",
    "small jump": "difference from the nearest known depth, as a share of depth: up to 5 %, fading with distance",
    "large jump": "the same, above 5 %",
    "slope": "range of the filled depth over 3 x 3 pixels, as a share of depth",
    "spread": "standard deviation of the depths at which walks from the pixel end, as a share of depth",
    "departure": "difference from the mean of those depths, as a share of depth",
    "steps": "length of those walks, in steps",
    "aside": "distance of the mean of their end points [px of a frame 640 px wide]",
    "edge": "edge strength at the pixel",
    "edge near": "largest edge strength within 3 px",
    "edges around": "mean edge strength within 15 px",
}
"""Columns of `error_features` -> their descriptions; those before "edge" are logarithms."""

_LARGE_JUMP = 0.05
"""Jump to the nearest known depth, as a share of depth, above which it has full weight at any distance."""

_FADING = 0.3
"""The weight of a smaller jump is distance^-0.3: far from known depth, a small jump is hardly informative."""

_WIDTH = 640
"""Gaps and distances are scaled to a frame whose longer side has this many pixels: the angle matters."""

_RIM = 9
"""Window [px] in which the widest part of a gap is searched: at its rim, depth is known on one side only."""

_LEVELS = 6
"""Number of times that the grid is halved, to find bends over 1, 2, 4, ... 64 px."""

_WINDOW = 9
"""Window, in pixels of the halved grid, over which bends are averaged."""

_UNSEEN_BEND = 0.02
"""Bend, as a share of depth, assumed where no three pixels in a row are known."""

_NEAR, _AROUND = 7, 31
"""Windows [px] in which edges are searched."""

_LEAST_SHARE, _LEAST_STEPS, _LEAST_ASIDE = 1e-3, 0.1, 1.0
"""Minimum values of features from the walks."""


def filled_pixels(frame: RGBDFrame, depth: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Pixels, bool (H, W), without depth in the frame and with depth in `depth`; InputError if the shapes differ."""
    check_shape("The completed depth", depth.shape, frame.shape)
    return ~frame.known & np.isfinite(depth) & (depth > 0)


def default_edges(frame: RGBDFrame) -> FrameEdges:
    """The edges of the default preset's filter in a frame; its notes say why others replace them."""
    try:
        return find_edges(frame, edge_parameters(Parameters()) or BlockParameters())
    except InstallationError as error:  # in a run without a network
        by_canny = find_edges(frame, BlockParameters(detector="canny"))
        return replace(by_canny, notes=(f"Canny's edges are used for the expected error: {error}",))


def walks_with_edges(frame: RGBDFrame, edges: Array) -> Walks:
    """Walks in a frame with edges (H, W); those with its `default_edges` are computed once."""
    return _default_walks(frame) if edges is default_edges(frame).strength else walk(frame.depth, edges)


@once_per_frame
def _default_walks(frame: RGBDFrame) -> Walks:
    return walk(frame.depth, default_edges(frame).strength)


_MAX_PIXELS = 1 << 22
"""Number of pixels of a frame up to which every pixel has features of its own. The pixels of larger frames are small
beside the gaps, and the features were chosen on frames of 640 x 480."""


def feature_cell(shape: tuple[int, int]) -> int:
    """Side [px] of the squares of pixels that share features in a frame of this shape."""
    cell = 1
    while shape[0] * shape[1] > cell**2 * _MAX_PIXELS:
        cell *= 2
    return cell


def in_cells(values: NDArray, filled: NDArray[np.bool_], cell: int) -> NDArray:
    """One value for every square of pixels: that of a filled pixel if there is any, the first one's otherwise."""
    if cell == 1:
        return values
    found = values[::cell, ::cell].copy()
    for y, x in np.ndindex(cell, cell):
        here = filled[y::cell, x::cell]
        np.copyto(found[: here.shape[0], : here.shape[1]], values[y::cell, x::cell], where=here)
    return found


def error_features(frame: RGBDFrame, depth: NDArray[np.floating], edges: Array, cell: int = 1) -> Array:
    """Compute the features of every filled pixel, or of every square of pixels with a filled one.

    Parameters
    ----------
    frame : RGBDFrame
        A frame with some known depth.
    depth : ndarray of float, shape (H, W)
        Completed depth [m].
    edges : ndarray of float32, shape (H, W)
        Edge strength.
    cell : int
        Side of the squares [px], see `feature_cell`.

    Returns
    -------
    ndarray of float32, shape (N, 13)
        Rows in the order of `filled_pixels`, or of those `in_cells`; the columns are `FEATURES`.
    """
    filled = filled_pixels(frame, depth)
    if not filled.any():
        return np.empty((0, len(FEATURES)), np.float32)
    walks = walks_with_edges(frame, edges)
    if cell > 1:
        size = [-(-side // cell) for side in reversed(frame.shape)]
        edges, walks = np.asarray(cv2.resize(edges, size, interpolation=cv2.INTER_AREA)), walks.in_cells(cell)
    known, completed, there = (in_cells(values, filled, cell) for values in (frame.depth, depth, filled))
    return features_at(np.flatnonzero(there), known, completed, edges, walks)


def features_at(
    places: NDArray[np.intp], known_depth: Array, depth: NDArray[np.floating], edges: Array, walks: Walks
) -> Array:
    """Compute `error_features` at some of the filled pixels, given by their flat indices.

    Parameters
    ----------
    places : ndarray of int, shape (N,)
        Flat indices of pixels without known depth and with completed depth.
    known_depth, depth : ndarray of float, shape (H, W)
        Known and completed depth [m]; unknown is NaN, not completed is NaN or 0.
    edges : ndarray of float32, shape (H, W)
    walks : Walks
        Walks from every pixel to known depth, with these edges.
    """

    def there(values: NDArray) -> Array:
        return np.asarray(values.ravel()[places])

    z, nearest, slope, distance, gap = _local_depths(places, known_depth, depth)
    check_cancelled()
    logarithm, usual_width = np.log(z), np.float32(_WIDTH / max(known_depth.shape))
    jump = np.log(np.abs(z - nearest) / z + FLOOR) - np.log(_LARGE_JUMP)
    columns = [
        logarithm,
        np.log(gap * usual_width),
        np.log(_bend(known_depth, distance, places) / z + FLOOR),
        np.minimum(jump, 0) * distance**-_FADING,
        np.maximum(jump, 0),
        np.log(slope / z + FLOOR),
        np.log(there(walks.spread) + _LEAST_SHARE),
        np.log(np.abs(logarithm - there(walks.depth)) + _LEAST_SHARE),
        np.log(there(walks.steps) + _LEAST_STEPS),
        np.log(there(walks.aside) * usual_width + _LEAST_ASIDE),
        there(edges),
        there(cv2.dilate(edges, np.ones((_NEAR, _NEAR), np.uint8))),
        there(cv2.blur(edges, (_AROUND, _AROUND))),
    ]
    return np.stack(columns, dtype=np.float32).T  # the model reads them column by column


def _local_depths(places: NDArray[np.intp], known_depth: Array, depth: NDArray[np.floating]) -> list[Array]:
    """At some pixels: depth, depth of the nearest known pixel, range of depth over 3 x 3 pixels [m]; distance to known
    depth and width of the gap [px]."""
    known = np.isfinite(known_depth)
    distance, nearest = nearest_values(known_depth, known)
    gap = np.asarray(cv2.dilate(distance, np.ones((_RIM, _RIM), np.uint8)), np.float32)
    check_cancelled()
    dense = np.where(~known & np.isfinite(depth) & (depth > 0), depth, nearest).astype(np.float32, copy=False)
    square = np.ones((3, 3), np.uint8)
    slope = np.asarray(cv2.dilate(dense, square), np.float32)
    slope -= cv2.erode(dense, square)
    return [values.ravel()[places] for values in (dense, nearest, slope, distance, gap)]


def _bend(depth: Array, distance: Array, places: NDArray[np.intp]) -> Array:
    """Mean deviation [m] of the known depth from straight lines, around some pixels and over their distance to it.

    On level n of a pyramid of block means, half the second difference of neighbours is the error of a straight line
    over 2^n px; each pixel interpolates its local mean between the two levels next to its distance.
    """
    known = np.isfinite(depth)
    count, total = known.astype(np.float32), np.where(known, depth, np.float32(0))
    level_of_pixel = np.clip(np.log2(distance), 0, _LEVELS)
    usual = _UNSEEN_BEND * float(np.median(depth[known])) / 2
    bend = np.zeros(level_of_pixel.shape, np.float32)
    for level in range(int(np.ceil(level_of_pixel.max())) + 1):
        bends, seen = _second_differences(count, total)
        # a level without known triples is assumed to bend twice as much as the finer one
        usual = float(bends.sum() / seen.sum()) if seen.any() else 2 * usual
        local = _local_mean(bends, seen, usual)
        size = (local.shape[1] << level, local.shape[0] << level)
        full = cv2.resize(local, size, interpolation=cv2.INTER_LINEAR)[: depth.shape[0], : depth.shape[1]]
        bend += full.ravel()[places] * np.maximum(1 - np.abs(level_of_pixel - level), 0)
        count, total = sums_of_four(count), sums_of_four(total)
    return bend


def _second_differences(count: Array, total: Array) -> tuple[Array, Array]:
    """Sum over both directions of half the absolute second differences of means, and their number."""
    known = count > 0
    mean = np.divide(total, count, out=np.zeros_like(total), where=known)
    bends, seen = np.zeros_like(mean), np.zeros_like(mean)
    half = np.array([[0.5, -1, 0.5]], np.float32)
    for kernel in (half, half.T):
        three = np.ones(kernel.shape, np.uint8)
        whole = cv2.erode(known.astype(np.uint8), three, borderType=cv2.BORDER_CONSTANT, borderValue=0)
        bend = np.asarray(cv2.filter2D(mean, cv2.CV_32F, kernel), np.float32)
        np.abs(bend, out=bend)
        bend *= whole
        bends += bend
        seen += whole
    return bends, seen


def _local_mean(sums: Array, counts: Array, usual: float) -> Array:
    """Local mean around every pixel, with `usual` as one additional sample."""
    around, number = (
        np.asarray(cv2.blur(values, (_WINDOW, _WINDOW), borderType=cv2.BORDER_CONSTANT), np.float32)
        for values in (sums, counts)
    )
    for values, more in ((around, usual), (number, 1)):
        values *= np.float32(_WINDOW * _WINDOW)
        values += np.float32(more)
    around /= number
    return around


# The model: from the features of a filled pixel to its error.

WITHIN = 0.6827
"""Wanted share of errors within the expected error: as for one standard deviation."""

WITHIN_TWICE = 0.9545
"""Wanted share of errors within twice the expected error: as for two standard deviations."""

_GAP = list(FEATURES).index("gap")
_NARROW, _WIDE = np.log(2.0), np.log(8.0)
"""Logarithms of the gap widths [px] up to which a frame's difficulty has no effect, and from which its full effect."""

_MAX_DEVIATION = 0.5
"""Maximum deviation of a frame's difficulty from the usual one."""


Curve = tuple[tuple[float, ...], tuple[float, ...]]
"""Contribution of one feature to the logarithm of the expected error, linear between knots and constant beyond: the
knots, and its values there."""


@dataclass(frozen=True)
class ErrorModel:
    """Logarithm of the expected error as a share of depth: a sum of curves.

    Attributes
    ----------
    level : float
        Constant term.
    curves : tuple of Curve
        One for each of `FEATURES`.
    usual, own : float
        The usual difficulty of frames, and the weight of a frame's deviation from it in wide gaps.
    """

    level: float
    curves: tuple[Curve, ...]
    usual: float = 0.0
    own: float = 0.0

    def logarithms(self, features: NDArray[np.floating]) -> NDArray[np.float64]:
        """Logarithms of expected errors as shares of depth, for features (N, 13), in a frame of usual difficulty."""
        curves = [np.array(curve) for curve in self.curves]
        most = max(2, *(curve.shape[1] for curve in curves))
        bends = np.stack([np.pad(curve, ((0, 0), (0, most - curve.shape[1])), "edge") for curve in curves])
        return self.level + _sum_of_curves(np.ascontiguousarray(features.T), bends)

    def shares(self, features: NDArray[np.floating], difficulty: float | None = None) -> NDArray[np.float64]:
        """Expected errors as shares of depth, at least `FLOOR` and at most 1.

        Parameters
        ----------
        features : ndarray of float, shape (N, 13)
            See `error_features`.
        difficulty : float, optional
            Difficulty of the frame (`frame_difficulty`); the usual one if unknown.
        """
        total = self.logarithms(features)
        if difficulty is not None:
            total += self.own * unusual(difficulty, self.usual) * gap_weight(features)
        return np.exp(np.clip(total, np.log(FLOOR), 0.0))


def _add_curves(features: NDArray[np.floating], bends: NDArray[np.float64]) -> NDArray[np.float64]:
    total = np.zeros(features.shape[1])
    for column in range(features.shape[0]):
        knots, values = bends[column]
        for i in range(total.size):
            feature, k = features[column, i], 1
            while k < knots.size - 1 and feature >= knots[k]:
                k += 1
            share = 1.0  # beyond the last knot
            if feature < knots[k]:
                share = max((feature - knots[k - 1]) / (knots[k] - knots[k - 1]), 0.0)
            total[i] += values[k - 1] + share * (values[k] - values[k - 1])
    return total


@compiled(_add_curves)
def _sum_of_curves(features: NDArray[np.floating], bends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum over features (13, N) of their curves, given by knots and values (13, 2, K), of which the last may repeat."""
    return np.sum([np.interp(column, *curve) for column, curve in zip(features, bends, strict=True)], axis=0)


def unusual(difficulty: float, usual: float) -> float:
    """Deviation of a difficulty from the usual one, clipped since the test is coarse."""
    return min(max(difficulty - usual, -_MAX_DEVIATION), _MAX_DEVIATION)


def gap_weight(features: NDArray[np.floating]) -> NDArray[np.floating]:
    """Weight of a frame's difficulty: from 0 in narrow gaps to 1 in wide ones."""
    return np.clip((features[:, _GAP] - _NARROW) / (_WIDE - _NARROW), 0.0, 1.0)

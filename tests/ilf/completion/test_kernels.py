"""The inner loops: as they are compiled, as they are written, and in numpy they give the same."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ilf._runtime import compiling
from ilf._runtime.compiling import is_compiled
from ilf.completion import banded
from ilf.completion.edge_aware import shape as trend
from ilf.completion.edge_aware import smoothness as kernels
from ilf.completion.edge_aware.smoothness import Weights
from ilf.data import pixel_grids
from ilf.segmentation import extraction as boundaries

SHAPES = [(1, 1), (1, 4), (5, 1), (3, 2), (7, 9)]


def _ways(name):
    """A kernel in numpy, as loops in plain Python, and as it runs here."""
    chosen = getattr(kernels, name)
    return [chosen.__wrapped__, getattr(kernels, f"_{name}"), chosen]


def _arrays(shape, count):
    return list(np.random.default_rng(shape).random((count, *shape), np.float32) + np.float32(0.5))


def _weights(shape):
    rng, weights = np.random.default_rng(shape), Weights.none(shape)
    for part in (weights.slope_x, weights.slope_y, weights.bend_x, weights.bend_y):
        part[:] = rng.random(part.shape)
    return weights.framed


CALLS = [
    ("pull", lambda a, weights: (a[0], weights, kernels.framed(a[1]), a[2])),
    ("advance", lambda a, _: (a[0], a[1], a[2], np.float32(0.3), a[3], a[4])),
    ("turn", lambda a, _: (a[0], a[1], np.float32(0.7), a[2])),
    ("tally", lambda a, _: a),
    ("spread", lambda a, weights: (weights, a[0])),
    ("spread", lambda a, weights: (weights, a[0].astype(np.float64))),
    ("weaken_links", lambda a, weights: (weights, a[0], a[1], np.float32(0.3))),
]
"""Kernels, and what they are given of six arrays and of weights."""


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("name", "given"), CALLS, ids=[name for name, _ in CALLS])
def test_a_kernel_gives_the_same_in_all_ways(name, given, shape):
    """What it returns, and what it has made of the arrays."""
    ends = []
    for way in _ways(name):
        arguments = given(_arrays(shape, 6), _weights(shape))
        result = way(*arguments)
        ends.append((0 if result is None else result, *arguments))
    for end in ends[1:]:
        for one, expected in zip(end, ends[0], strict=True):
            assert_allclose(one, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("shape", [(5, 4), (7, 9)])
def test_steps_one_after_the_other(shape, monkeypatch):
    """In machine code, which knows of the other kernels by their loops, and in numpy: as many at a time as there is
    room for, and no more than until they are steady."""
    counts, start, inside, trend, totals = _arrays(shape, 5)
    weights, ends = _weights(shape), []
    for machine_code in (True, False):
        if not machine_code:
            monkeypatch.setattr(compiling, "is_compiled", lambda: False)
        direction, image = np.zeros_like(kernels.framed(start)), np.empty_like(start)
        kernels.pull(counts, weights, kernels.framed(start), image)
        state = direction, totals - image
        told = inside, trend, counts, totals
        inverse, sizes = np.full_like(start, 0.1), (float(np.square(state[1]).sum()) / 10, 0.0, 0.0)
        found, sums = np.empty((4, *shape), np.float32), np.empty((4, 3))
        steps, *sizes = kernels.descend(counts, weights, inverse, state, (*sizes,), told, 0.0, start, found, sums)
        assert steps == 4
        more, _, _ = kernels.descend(
            counts, weights, inverse, state, (*sizes, 0.0), told, np.inf, found[-1], last := np.empty_like(found), sums
        )
        assert more == 1
        ends.append((*found, last[0], sums, *sizes))
    for one, other in zip(*ends, strict=True):
        assert_allclose(one, other, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("creased", [False, True])
@pytest.mark.parametrize("shape", [*SHAPES, (150, 3)])
def test_link(shape, creased):
    smooth, crease = np.random.default_rng(shape).random((2, *shape), np.float32)
    expected, *others = (np.full((4, shape[0] + 4, shape[1]), -1, np.float32) for _ in range(3))
    for way, out in zip(_ways("link"), (expected, *others), strict=True):
        way(smooth, np.float32(2), np.float32(3), crease if creased else None, out)
    weights = Weights(expected)
    parts = weights.slope_x, weights.slope_y, weights.bend_x, weights.bend_y
    assert np.count_nonzero(expected >= 0) == sum(part.size for part in parts)
    for out in others:
        assert_array_equal(out, expected)


def test_parts_are_taken_in():
    """Of the parts, 1 is a speck, 2 holds a region already, 3 and 4 become regions."""
    parts = np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 4, 4, 4, 4, 3, 3, 3, 3, 3], np.int32)
    regions = np.where(np.arange(parts.size) == 5, np.int32(7), np.int32(0))
    assert boundaries._add_new_parts(parts, regions, 7) == 9
    assert regions.tolist() == [0] * 5 + [7] + [0] * 3 + [9] * 4 + [8] * 5
    assert boundaries._add_new_parts(parts, regions, 9) == 9


@pytest.mark.parametrize("known", [0.02, 0.3, 0.9])
@pytest.mark.parametrize("shape", [*SHAPES, (12, 17), (30, 20)])
def test_filling_from_the_nearest_of_several_pixels_at_one_distance(shape, known):
    rng = np.random.default_rng(shape)
    values = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
    values[(rng.random(shape) > known) & (values != values.size // 2)] = np.nan
    expected = pixel_grids.filled_from_nearest.__wrapped__(values)
    for way in (pixel_grids._fill_by_loops, pixel_grids.filled_from_nearest):
        assert_array_equal(way(values), expected)


@pytest.mark.parametrize("shape", SHAPES)
def test_second_differences_of_known_depth(shape):
    (depth,) = _arrays(shape, 1)
    rng = np.random.default_rng(shape)
    depth[rng.random(shape) < 0.1] = np.nan
    mask = rng.random(shape) < 0.9
    ways = trend._bends.__wrapped__, trend._bends_one_by_one, trend._bends
    expected, *others = (np.sort(way(depth, mask)) for way in ways)
    for found in others:
        assert_allclose(found, expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (6, 1), (2, 3), (5, 4), (4, 7)])
@pytest.mark.parametrize("way", [banded.solve_band, banded.solve_band.__wrapped__, banded._cholesky])
def test_grids_are_solved(shape, way, monkeypatch):
    """Against the dense matrix of the same entries."""
    monkeypatch.setattr(banded, "solve_band", way)
    rng, (height, width) = np.random.default_rng(shape), shape
    along_x, along_y = ([-rng.random(shape), 0.3 * rng.random(shape)] for _ in range(2))
    for step in (1, 2):
        along_x[step - 1][:, max(width - step, 0) :] = 0
        along_y[step - 1][max(height - step, 0) :] = 0
    diagonal = 6 + rng.random(shape)
    matrix = np.diag(diagonal.ravel())
    numbers = np.arange(height * width).reshape(shape)
    for y, x in np.ndindex(shape):
        for step in (1, 2):
            if x + step < width:
                matrix[numbers[y, x], numbers[y, x + step]] = along_x[step - 1][y, x]
            if y + step < height:
                matrix[numbers[y, x], numbers[y + step, x]] = along_y[step - 1][y, x]
    matrix = np.triu(matrix) + np.triu(matrix, 1).T
    wanted = rng.random((3, *shape))
    found = banded.solve_grid(diagonal, tuple(along_x), tuple(along_y), wanted)
    expected = np.linalg.solve(matrix, wanted.reshape(3, -1).T).T.reshape(wanted.shape)
    assert_allclose(found, expected, rtol=1e-10)


def test_numba_is_asked_for_when_a_loop_is_first_run():
    """Importing it takes longer than all of the library's own files."""
    program = "import sys, ilf, ilf.completion.edge_aware.iteration; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program]).returncode == 0


def test_without_machine_code_the_plain_function_runs(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    program = "from ilf._runtime.compiling import is_compiled; import sys; sys.exit(is_compiled())"
    assert subprocess.run([sys.executable, "-c", program]).returncode == 0


@pytest.mark.skipif(not is_compiled(), reason="numba is not installed")
def test_machine_code_is_kept_with_the_user_and_not_beside_the_sources(tmp_path):
    """An uninstalled package leaves nothing behind."""
    (tmp_path / "loops.py").write_text("def doubled(value):\n    return 2 * value\n")
    program = (
        "import loops, numba; from ilf._runtime.compiling import compiled\n"
        "assert compiled()(loops.doubled)(2) == 4\n"
        "assert numba.config.CACHE_DIR == ''\n"
    )
    folders = {"HOME": tmp_path / "home", "XDG_CACHE_HOME": tmp_path / "cache", "LOCALAPPDATA": tmp_path / "cache"}
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {name: str(path) for name, path in folders.items()}
    environment["PYTHONPATH"] = os.pathsep.join([str(tmp_path), *sys.path])
    subprocess.run([sys.executable, "-c", program], env=environment, check=True)
    kept = {path.relative_to(tmp_path).parts[0] for path in tmp_path.rglob("*.nbi")}
    assert kept
    assert kept <= {"home", "cache"}

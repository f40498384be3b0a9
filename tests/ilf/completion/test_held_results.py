"""What comes out stays what it was, whatever is changed inside: blocks, depth and outcomes over many parameters.

`held_results.json` holds blocks on a coarse grid and depth at some pixels, as they were when it was written. Other
processors and library versions may differ in the last digits, which all tolerances allow for. Where nothing
else is said, edges are contours: depth edges change with their network's weights. After a change that means to alter
results:

    python -m tests.ilf.completion.test_held_results
"""

import json
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cv2
import numpy as np
import pytest

import ilf
from ilf._runtime import compiling
from ilf._runtime.installation import asset_path
from ilf.completion.continuation import continue_plane
from ilf.data.by_hand import DepthByHand
from ilf.data.parameters import PAPER_BLOCKS
from ilf.segmentation.editing.patches import border_pixels
from ilf.segmentation.extraction import extract

TABLE = Path(__file__).with_name("held_results.json")
DEPTH_M = 5e-5
"""How far depth may be off [m]."""
AT_JUMPS, AT_JUMPS_M = 0.05, 1e-3
"""In fill + denoise, so many of the pixels may be off by as much [m]: which side of a jump a pixel joins is decided by
a threshold, and its last digits differ between processors of Intel and AMD. So may the iterations then."""
BLOCKS = 0.01
"""Share of the pixels looked at that may belong to other blocks."""

EXTRACTIONS: dict[str, dict[str, Any]] = {
    "default": {},
    "few": {"granularity": 0.0},
    "many": {"granularity": 1.0, "min_size": 0.1},
    "large": {"min_size": 5.0},
    "known": {"min_known_share": 0.4},
    "existing": {"existence_rate": 0.8},
    "existing half": {"existence_rate": 0.6, "min_size": 2.0},
    "canny": {"detector": "canny"},
    "canny, other thresholds": {"detector": "canny", "canny_sigma": 0.5, "canny_high": 0.3, "canny_low_ratio": 0.8},
    "threshold": {"threshold": 0.4},
    "colour": {"use_depth": False},
    "creases": {"use_creases": True, "granularity": 0.8},
    "jumps": {"depth_jump": 0.3, "depth_jump_share": 0.1},
    "thin": {"dilation": 0},
    "thick": {"dilation": 6},
    "margin": {"margin": 7},
}
UNCORRECTED: dict[str, Any] = {"correction": False}
"""What is held is the filter's depth, which other weights of a network do not change."""

FILTERS: dict[str, tuple[str, dict[str, Any]]] = {
    "best": ("best", UNCORRECTED),
    "best, denoise": ("best", UNCORRECTED | {"mode": "fill+denoise"}),
    "best, no trend": ("best", UNCORRECTED | {"trend": False}),
    "best, no jumps": ("best", UNCORRECTED | {"jump_share": 0.0}),
    "best, many jumps": ("best", UNCORRECTED | {"jump_share": 0.0005}),
    "best, noisy": ("best", UNCORRECTED | {"noise": 0.02, "mode": "fill+denoise"}),
    "best, stiff": ("best", UNCORRECTED | {"smoothness": 30.0, "slope_weight": 0.3}),
    "best, bending": ("best", UNCORRECTED | {"bending_weight": 5.0, "slope_weight": 0.0}),
    "best, canny": ("best", UNCORRECTED | {"edges": "canny", "edge_scale": 0.5}),
    "best, boundaries": ("best", UNCORRECTED | {"boundary_strength": 2.0, "trust_distance": 1.0}),
    "best, short": ("best", UNCORRECTED | {"max_iterations": 7}),
    "best, exact": ("best", UNCORRECTED | {"s_criteria": 0.0}),
    "best, held out": ("best", UNCORRECTED | {"validation_share": 0.2}),
    "best, little known": ("best", UNCORRECTED | {"min_known_share": 0.85, "min_known_pixels": 500}),
    "best, drawn": ("best", UNCORRECTED),
    "best, drawn, denoise": ("best", UNCORRECTED | {"mode": "fill+denoise"}),
    "paper": ("paper", {}),
    "paper, denoise": ("paper", {"mode": "fill+denoise"}),
    "paper, centred": ("paper", {"centred": True}),
    "paper, start and step": ("paper", {"staged_start": 2.0, "stage_step": 1.5}),
    "paper, padding": ("paper", {"padding": 1.25, "shortest_wavelength": 8.0}),
    "paper, colourless": ("paper", {"rgb_iterations": 0}),
    "paper, colour": ("paper", {"rgb_iterations": 400, "rgb_dilation": 6}),
    "paper, strict": ("paper", {"s_criteria": 0.0005, "max_iterations": 150}),
    "paper, held out": ("paper", {"validation_share": 0.2}),
    "released-code": ("released-code", {"max_iterations": 120}),
    "released-code, steady": ("released-code", {"max_iterations": 120, "stop_when_steady": True, "s_criteria": 0.02}),
    "released-code, start": ("released-code", {"max_iterations": 60, "linear_start": 3.0, "precision": "float32"}),
}

ON_THE_ROOM = ("best", "best, denoise", "best, canny", "best, drawn", "paper", "paper, colour", "released-code")
"""Those that are held on the larger frame, too."""

COMPLETIONS = [*(("bowl", name) for name in FILTERS), *(("room", name) for name in ON_THE_ROOM)]


@cache
def room() -> ilf.RGBDFrame:
    """The bundled sample, every fourth row and column of it."""
    whole = ilf.load_frame(asset_path("samples/room"))
    return ilf.RGBDFrame(whole.rgb[::4, ::4].copy(), whole.depth[::4, ::4], name="room / 4")


@cache
def bowl() -> ilf.RGBDFrame:
    """A bowl before a slanted wall, with noise, single missing pixels, holes and flying pixels at the rim."""
    rows, columns = np.indices((72, 96)).astype(float)
    rng = np.random.default_rng(5)
    off = np.hypot(rows - 36, columns - 40)
    depth = np.where(off < 24, 1.3 + 0.0004 * off**2, 2.0 + 0.004 * columns - 0.002 * rows)
    depth += 0.001 * depth**2 * rng.standard_normal(depth.shape)
    rim = np.abs(off - 24) < 1
    depth[rim] = 1.6
    depth[rng.random(depth.shape) < 0.1] = np.nan
    depth[30:44, 20:56] = np.nan
    depth[5:15, 60:90] = np.nan
    rgb = np.where((off < 24)[..., None], [200, 140, 60], [70, 90, 160]) + rng.integers(-12, 13, (72, 96, 1))
    return ilf.RGBDFrame(rgb.astype(np.uint8), depth, name="bowl")


FRAMES = {"room": room, "bowl": bowl}


@cache
def blocks_of(frame: str) -> np.ndarray:
    return ilf.extract_blocks(FRAMES[frame](), PAPER_BLOCKS)


def left_borders(frame: str) -> np.ndarray:
    """The borders of all blocks in the left half: some blocks are drawn all round, some in part, some not at all."""
    labels = blocks_of(frame)
    return border_pixels(labels) & (np.arange(labels.shape[1]) < labels.shape[1] // 2)


def coarse(picture: np.ndarray, step: int = 7) -> list[Any]:
    return picture[step // 2 :: step, step // 2 :: step].ravel().tolist()


def extraction(frame: str, name: str) -> dict[str, Any]:
    """The stages of an extraction in numbers."""
    stages = extract(FRAMES[frame](), PAPER_BLOCKS.replace(**EXTRACTIONS[name]))
    return {
        "strength": round(float(stages.strength.mean()), 5),
        "edges": int(stages.edges.sum()),
        "dilated": int(stages.dilated.sum()),
        "regions": int(np.unique(stages.contracted).size),
        "sizes": np.bincount(stages.blocks.ravel()).tolist(),
        "blocks": coarse(stages.blocks),
    }


def completion(frame: str, name: str) -> dict[str, Any]:
    """Outcomes, curves and depth of a completion in numbers; depth where anything was missing, and some of the rest."""
    source, (preset, changes) = FRAMES[frame](), FILTERS[name]
    drawn = left_borders(frame) if "drawn" in name else None
    parameters = ilf.preset(preset).replace(**({"edges": "combined"} | changes))
    result = ilf.complete(source, blocks_of(frame), parameters, drawn=drawn)
    missing = result.depth[~source.known][:: 40 if frame == "room" else 13]
    last = [result.history[label][-1] for label in result.history if result.history[label]]
    return {
        "outcomes": [
            [outcome.status.value, outcome.known, outcome.recovered, outcome.iterations, outcome.stages]
            for outcome in result.outcomes.values()
        ],
        "filled": [None if np.isnan(depth) else round(float(depth), 6) for depth in missing],
        "depth": [None if np.isnan(depth) else round(depth, 6) for depth in coarse(result.depth, 13)],
        "curves": [[round(float(value), 6) for value in (r.sigma_i, r.residual, r.held_out)] for r in last],
        "l1": [round(float(r.l1), 4) for r in last],
    }


@cache
def held() -> dict[str, Any]:
    return json.loads(TABLE.read_text(encoding="utf-8"))


def numbers(values: list[Any]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values], float)


@pytest.fixture(autouse=True)
def _loops_as_they_are_written(monkeypatch):
    """What is held comes from numpy; machine code, which sums in another order, is held to numpy elsewhere."""
    monkeypatch.setattr(compiling, "is_compiled", lambda: False)


@pytest.mark.parametrize("name", EXTRACTIONS)
@pytest.mark.parametrize("frame", FRAMES)
def test_blocks_are_what_they_were(frame, name):
    now, before = extraction(frame, name), held()["blocks"][f"{frame}: {name}"]
    for count in ("strength", "edges", "dilated"):
        assert now[count] == pytest.approx(before[count], rel=0.002), count
    assert now["regions"] == pytest.approx(before["regions"], abs=1)
    assert now["sizes"] == pytest.approx(before["sizes"], abs=BLOCKS * sum(before["sizes"]))
    assert np.mean(numbers(now["blocks"]) != numbers(before["blocks"])) <= BLOCKS


@pytest.mark.parametrize(("frame", "name"), COMPLETIONS)
def test_depth_is_what_it_was(frame, name):
    now, before = completion(frame, name), held()["depth"][f"{frame}: {name}"]
    for (status, *counts), (status_before, *counts_before) in zip(now["outcomes"], before["outcomes"], strict=True):
        assert status == status_before
        *pixels, iterations, _ = counts
        assert pixels == pytest.approx(counts_before[:2], rel=0.01)
        assert "denoise" in name or iterations == pytest.approx(counts_before[2], abs=1)
    for kind in ("filled", "depth"):
        off = np.abs(numbers(now[kind]) - numbers(before[kind]))
        assert np.array_equal(np.isnan(numbers(now[kind])), np.isnan(numbers(before[kind]))), kind
        at_jumps = off > DEPTH_M
        assert np.mean(at_jumps) <= (AT_JUMPS if "denoise" in name else 0), f"{kind}: {off[at_jumps]}"
        assert not (off > AT_JUMPS_M).any(), f"{kind}: {off[at_jumps]}"
    curves = (np.array(table["curves"], float) for table in (now, before))
    rtol, atol = (1e-2, 1e-4) if "denoise" in name else (1e-3, 2e-5)
    np.testing.assert_allclose(*curves, rtol=rtol, atol=atol)
    np.testing.assert_allclose(now["l1"], before["l1"], rtol=5e-5)


# What depends on more than parameters: guides, depth by hand, what no camera saw, streams; and the expected error.


def seen(depth: np.ndarray, **more: Any) -> ilf.RGBDFrame:
    return ilf.RGBDFrame(bowl().rgb, depth, **more)


def box(rows: slice, columns: slice) -> np.ndarray:
    mask = np.zeros(bowl().shape, bool)
    mask[rows, columns] = True
    return mask


@cache
def surface() -> np.ndarray:
    """The bowl and the wall without noise and gaps."""
    rows, columns = np.indices(bowl().shape)
    off = np.hypot(rows - 36, columns - 40)
    return np.where(off < 24, 1.3 + 0.0004 * off**2, 2.0 + 0.004 * columns - 0.002 * rows).astype(np.float32)


def boxed(said: str) -> ilf.RGBDFrame:
    """A box before a wall, with a gap over both that colour does not show."""
    rows, columns = np.indices((90, 120), np.float32)
    depth = np.where((abs(rows - 45) < 25) & (abs(columns - 60) < 30), 1.2 + rows / 300, 3 + columns / 120)
    gap = (abs(rows - 45) < 15) & (abs(columns - 90) < 20)
    waves = 0.02 * np.sin((rows + columns) / 5)
    guides = {
        "guide": 1 / depth,
        "uneven": np.where(rows + columns < 30, np.nan, 1 / depth + waves),
        "far": 50 - depth**2,
    }
    return ilf.RGBDFrame(np.full((90, 120, 3), 90, np.uint8), np.where(gap, np.nan, depth), guide=guides[said])


BOXED = np.ones((90, 120), np.int32)
IN_GAP = BOXED.copy()
IN_GAP[40:55, 80:95] = 9
"""Blocks of which one has no depth."""


def island() -> ilf.RGBDFrame:
    """A speck of wrong depth in a large hole."""
    depth = np.where(box(slice(4, 66), slice(26, 94)), np.nan, bowl().depth)
    return seen(np.where(box(slice(32, 36), slice(64, 69)), 9.0, depth))


def corridor() -> ilf.RGBDFrame:
    """A floor that leaves the range of the sensor."""
    rows, columns = np.indices((120, 160)).astype(np.float32)
    depth = 160 / (rows + 25)
    rgb = np.dstack((90 + 60 * (columns % 40 < 20), 60 + rows, 140 - rows / 2)).astype(np.uint8)
    return ilf.RGBDFrame(rgb, np.where((depth > 4) | (np.hypot(rows - 80, columns - 50) < 15), np.nan, depth))


def stream(preset: str = "best", **changes: Any) -> list[ilf.Completion]:
    """Three frames of a camera that moves to the right."""
    moved = (
        [np.roll(bowl().rgb, -2 * k, axis=1) for k in range(3)],
        [np.roll(surface(), -2 * k, axis=1) for k in range(3)],
    )
    frames = [ilf.RGBDFrame(rgb, np.where(bowl().known, depth, np.nan)) for rgb, depth in zip(*moved, strict=True)]
    with ilf.Stream(preset, **changes) as opened:
        return [opened.complete(one) for one in frames]


CANNY: dict[str, Any] = {"edges": "canny", "correction": False}
HAND = box(slice(34, 40), slice(26, 34))
NO_DEPTH = np.where(box(slice(5, 15), slice(60, 90)), 9, 1).astype(np.int32)
"""A block that is in a hole."""


def done(frame: ilf.RGBDFrame | None = None, blocks: Any = None, preset: str = "best", **given: Any) -> Any:
    """Complete the bowl, or another frame."""
    frame, blocks = bowl() if frame is None else frame, blocks_of("bowl") if blocks is None else blocks
    return ilf.complete(frame, blocks, preset, **CANNY | given if preset == "best" else given)


CASES: dict[str, Any] = {
    "best": done,
    "corrected": lambda: done(correction=True),
    "contours": lambda: done(edges="combined", correction=True),
    "depth edges": lambda: done(edges="rgbd"),
    "paper": lambda: done(preset="paper", max_iterations=300),
    "extrapolated": lambda: ilf.extrapolate(done(blocks=np.where(blocks_of("bowl") > 1, 0, 1).astype(np.int32))),
    "sparse": lambda: done(seen(np.where(np.indices((72, 96)).sum(axis=0) % 11 == 0, surface(), np.nan)), NO_DEPTH > 0),
    "sparse, corrected": lambda: done(
        seen(np.where(np.prod(np.indices((72, 96)) % 9 == 4, axis=0) > 0, surface(), np.nan)),
        NO_DEPTH > 0,
        correction=True,
    ),
    "guide": lambda: done(boxed(said="guide"), IN_GAP),
    "uneven guide": lambda: done(boxed(said="uneven"), IN_GAP),
    "guide, corrected": lambda: done(boxed(said="far"), BOXED, correction=True),
    "poor guide": lambda: done(guide=np.random.default_rng(1).normal(size=bowl().shape)),
    "by hand": lambda: done(blocks=NO_DEPTH, by_hand=np.where(HAND | (NO_DEPTH == 9), 1.8, np.nan)),
    "by hand, weak": lambda: done(by_hand=DepthByHand(np.where(HAND, np.float32(1.5), np.float32(np.nan)), 0.05)),
    "by hand, denoise": lambda: done(by_hand=np.where(HAND, 1.5, np.nan), mode="fill+denoise"),
    "by hand, paper": lambda: done(preset="paper", by_hand=np.where(HAND, 1.5, np.nan), max_iterations=200),
    "continued": lambda: done(
        blocks=NO_DEPTH, by_hand=continue_plane(bowl().depth, box(slice(0, 20), slice(56, 96)), NO_DEPTH == 9)[0]
    ),
    "outside view": lambda: done(seen(bowl().depth, outside_view=box(slice(30, 44), slice(20, 40)))),
    "outside view, filled": lambda: done(
        seen(bowl().depth, outside_view=box(slice(30, 44), slice(20, 40))), outside_view=True
    ),
    "suspect": lambda: done(island(), NO_DEPTH > 0),
    "out of range": lambda: done(corridor(), np.ones((120, 160), int)),
    "out of range, not": lambda: done(corridor(), np.ones((120, 160), int), out_of_range=False),
    "drawn": lambda: done(drawn=left_borders("bowl"), correction=True),
    "denoised": lambda: done(mode="fill+denoise", edges="combined"),
    "extrapolated corridor": lambda: ilf.extrapolate(done(corridor(), np.zeros((120, 160), np.int32))),
    "stream": lambda: stream(**CANNY),
    "stream, default": stream,
}
SHARES = (0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98)
CASE_M, CASE_SHARE = 2e-4, 0.005
"""How far quantiles of depth [m] and of the expected error (a share) may be off."""


def spread(values: np.ndarray) -> list[float]:
    """Number, mean and quantiles of the finite values."""
    there = values[np.isfinite(values)].astype(float)
    return [float(there.size), *np.round([there.mean(), *np.quantile(there, SHARES)], 7)] if there.size else [0.0]


def case(name: str) -> dict[str, list[float]]:
    """Depth and expected error of each block, and of each kind of pixel, in numbers."""
    found: dict[str, list[float]] = {}
    completions = CASES[name]()
    for number, one in enumerate(completions if isinstance(completions, list) else [completions]):
        error, unsupported = ilf.expected_error(one), ilf.unsupported(one)
        away = cv2.distanceTransform((~one.frame.known).astype(np.uint8), cv2.DIST_L2, 3)
        for label, outcome in one.outcomes.items():
            counts = outcome.known, outcome.recovered, outcome.by_hand, outcome.suspect
            inside = (one.blocks == label) & ~one.frame.known
            found[f"count {number} {label}"] = [float(count) for count in counts]
            found[f"depth {number} {label}"] = spread(one.depth[inside])
            found[f"error {number} {label}"] = spread(error[inside])
        for kind, pixels in {"near": (away > 0) & (away < 3), "far": away >= 3, "unsupported": unsupported}.items():
            found[f"error {number} {kind}"] = spread(error[pixels])
        found[f"depth {number} known"] = spread(one.depth[one.frame.known])
        found[f"count {number}"] = [float(mask.sum()) for mask in (one.extrapolated, unsupported, one.by_hand)]
    return found


@pytest.mark.parametrize("name", CASES)
def test_cases_are_what_they_were(name):
    now, before = case(name), held()["cases"][name]
    assert now.keys() == before.keys()
    loose = 5 if "denoise" in name else 1
    for what, numbers_before in before.items():
        (count, *rest), (count_before, *rest_before) = now[what], numbers_before
        if what.startswith("count"):
            assert now[what] == pytest.approx(numbers_before, rel=0.01, abs=1), what
            continue
        assert count == pytest.approx(count_before, rel=0.01, abs=1), what
        tolerance = {"abs": loose * CASE_M} if what.startswith("depth") else {"rel": loose * CASE_SHARE}
        assert rest == pytest.approx(rest_before, **tolerance), what


def main() -> None:
    """Write the table as it is now."""
    with patch.object(compiling, "is_compiled", lambda: False):
        found = {
            "blocks": {f"{frame}: {name}": extraction(frame, name) for frame in FRAMES for name in EXTRACTIONS},
            "depth": {f"{frame}: {name}": completion(frame, name) for frame, name in COMPLETIONS},
            "cases": {name: case(name) for name in CASES},
        }
    lines = [
        f'"{kind}": {{\n' + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in part.items()) + "}"
        for kind, part in found.items()
    ]
    TABLE.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")


if __name__ == "__main__":
    main()

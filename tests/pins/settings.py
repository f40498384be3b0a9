"""The settings whose results are pinned."""

from typing import Any

import cv2
import numpy as np

import ilf

from .frames import wall_with_neighbours

EXTRACTIONS: dict[str, dict[str, Any]] = {
    "default": {},
    "few": {"granularity": 0.0},
    "many": {"granularity": 1.0, "min_size": 0.1},
    "large": {"min_size": 5.0},
    "known": {"min_known_share": 0.4},
    "existing": {"existence_rate": 0.8},
    "rgbd": {"detector": "rgbd"},
    "canny": {"detector": "canny", "canny_sigma": 0.5, "canny_high": 0.3, "canny_low_ratio": 0.8},
    "three scales": {"multiscale": True},
    "threshold": {"threshold": 0.4},
    "colour": {"use_depth": False},
    "creases": {"use_creases": True, "granularity": 0.8},
    "jumps": {"depth_jump": 0.3, "depth_jump_share": 0.1},
    "thin": {"dilation": 0},
    "thick": {"dilation": 6},
    "margin": {"margin": 7},
}
"""Name -> parameters of the extraction."""


def left_borders(frame: ilf.RGBDFrame, blocks: np.ndarray) -> np.ndarray:
    """The borders of all blocks in the left half of the frame."""
    steps = cv2.morphologyEx(blocks.astype(np.float32), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    return (steps > 0) & (np.indices(frame.shape)[1] < frame.shape[1] // 2)


def stated(frame: ilf.RGBDFrame, _blocks: np.ndarray) -> np.ndarray:
    """Depth by hand: 1.9 m at every third missing pixel."""
    missing = ~np.isfinite(frame.depth)
    return np.where(missing & (np.cumsum(missing).reshape(frame.shape) % 3 == 0), 1.9, np.nan)


def other_guide(frame: ilf.RGBDFrame, _blocks: np.ndarray) -> np.ndarray:
    """The known depth, blurred, and the mean where nothing is known."""
    return cv2.GaussianBlur(np.nan_to_num(frame.depth, nan=float(np.nanmean(frame.depth))), (0, 0), 3)


def with_mask(frame: ilf.RGBDFrame) -> ilf.RGBDFrame:
    """The frame, its right third marked as invalid."""
    return frame.with_invalid_mask(np.indices(frame.shape)[1] > frame.shape[1] * 2 // 3)


def seen_in_part(frame: ilf.RGBDFrame) -> ilf.RGBDFrame:
    """The frame, whose missing pixels in the upper half are outside the depth camera's view."""
    outside = np.indices(frame.shape)[0] < frame.shape[0] // 2
    return ilf.RGBDFrame(frame.rgb, frame.depth, frame.intrinsics, frame.name, outside_view=outside)


COMPLETIONS: dict[str, dict[str, Any]] = {
    "best": {},
    "best, denoise": {"mode": "fill+denoise"},
    "best, uncorrected": {"correction": False},
    "best, uncorrected, denoise": {"correction": False, "mode": "fill+denoise"},
    "best, ideal": {"filter": "ideal"},
    "best, no trend": {"trend": False},
    "best, no jumps": {"jump_share": 0.0},
    "best, many jumps": {"jump_share": 0.0005},
    "best, noisy": {"noise": 0.02, "mode": "fill+denoise"},
    "best, stiff": {"smoothness": 30.0, "slope_weight": 0.3},
    "best, bending": {"bending_weight": 5.0, "slope_weight": 0.0},
    "best, rgbd": {"edges": "rgbd"},
    "best, canny": {"edges": "canny", "edge_scale": 0.5},
    "best, three scales": {"multiscale": True},
    "best, boundaries": {"boundary_strength": 2.0, "trust_distance": 1.0},
    "best, edges of all blocks": {"block_local_edges": False},
    "best, short": {"max_iterations": 7},
    "best, exact": {"s_criteria": 0.0},
    "best, held out": {"validation_share": 0.2},
    "best, little known": {"min_known_share": 0.85, "min_known_pixels": 500},
    "best, dense": {"min_known_share": 0.85, "extrapolate": True},
    "best, drawn": {"drawn": left_borders},
    "best, drawn, denoise": {"drawn": left_borders, "mode": "fill+denoise"},
    "best, by hand": {"by_hand": stated},
    "best, by hand, denoise": {"by_hand": stated, "mode": "fill+denoise"},
    "best, guide": {"guide": other_guide},
    "best, invalid": {"frame": with_mask},
    "best, outside the view": {"frame": seen_in_part},
    "best, fill outside the view": {"frame": seen_in_part, "outside_view": True},
    "best, neighbours": {"on": "wall", "frame": lambda _: wall_with_neighbours()},
    "best, neighbours, denoise": {"on": "wall", "frame": lambda _: wall_with_neighbours(), "mode": "fill+denoise"},
    "best, own": {"own": {1: "paper", 2: ilf.preset("best", smoothness=5.0)}},
    "best, one block": {"only": [2]},
    "best, extracted": {"blocks": None, "granularity": 0.8, "detector": "rgbd"},
    "best, everything": {
        "frame": with_mask,
        "drawn": left_borders,
        "by_hand": stated,
        "own": {1: "paper"},
        "extrapolate": True,
        "mode": "fill+denoise",
    },
    "paper": {"preset": "paper"},
    "paper, denoise": {"preset": "paper", "mode": "fill+denoise"},
    "paper, centred": {"preset": "paper", "centred": True},
    "paper, start and step": {"preset": "paper", "staged_start": 2.0, "stage_step": 1.5},
    "paper, padding": {"preset": "paper", "padding": 1.25, "shortest_wavelength": 8.0},
    "paper, colourless": {"preset": "paper", "rgb_iterations": 0},
    "paper, colour": {"preset": "paper", "rgb_iterations": 400, "rgb_dilation": 6},
    "paper, strict": {"preset": "paper", "s_criteria": 0.0005, "max_iterations": 150},
    "paper, held out": {"preset": "paper", "validation_share": 0.2},
    "paper, extracted": {"preset": "paper", "blocks": None},
    "paper, by hand": {"preset": "paper", "by_hand": stated},
    "released-code": {"preset": "released-code", "max_iterations": 120},
    "released-code, start": {
        "preset": "released-code",
        "max_iterations": 60,
        "linear_start": 3.0,
        "precision": "float32",
    },
    "files": {"files": {"depth_formats": ("png", "tiff"), "depth_units": 5000.0, "cloud": "pcd", "mesh": "obj"}},
    "files, text": {"files": {"cloud": "ply-ascii", "mesh": "ply", "axes": "y-up", "cloud_unit": "mm"}},
    "files, no flying pixels": {"files": {"cloud": "xyzrgb", "mesh": "glb", "drop_flying": True, "normals": True}},
    "files, world": {"on": "wall", "files": {"cloud": "xyz", "mesh": "ply", "expected_error": False, "axes": "world"}},
}
"""Name -> arguments of `ilf.complete`; a function is called with the frame and its blocks. Besides: `frame`, what is
made of the frame; `blocks`, the default's if left out; `only`, the blocks that are run; `files`, options of what is
saved; `on`, the only frame where it makes sense."""

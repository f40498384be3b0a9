"""Make README's picture: `python assets/docs/make_before_after.py`, which `.ci/site` calls.

Two generated frames completed by `best`: one that it does well, and the bundled sample, one that it does not. Each row
shows colour with blocks, measured depth, completed depth, and its error where depth was missing and is known exactly.
The file is written only if the picture has changed visibly.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf._runtime.installation import asset_path
from ilf.data.pictures import depth_colours
from ilf.drawing.blocks import block_overlay
from ilf.drawing.colours import robust_depth_levels, to_indices
from ilf.evaluation.evaluation import evaluate_completion

sys.path.insert(0, str(Path(__file__).parents[1] / "models"))
import make_scenes

PICTURE = Path(__file__).parent / "images" / "before-after.jpg"
DESK = (42, 9)
"""Seed and number of the generated scene; the networks were trained on others."""
WORST = 0.3
"""Error at the end of the colours [m]."""
_SIZE, _GAP, _LINE = (480, 360), 6, 26
_QUALITY = 80
_VISIBLE = 1.0
"""Mean difference of two pictures from which on they differ visibly [grey levels]."""


def desk() -> ilf.RGBDFrame:
    """A desk as a simulated stereo camera sees it."""
    made = make_scenes.record(*DESK, size=(640, 480))
    return ilf.RGBDFrame(made["rgb"], made["measured"], name="A generated desk", ground_truth=made["exact"])


def row(frame: ilf.RGBDFrame) -> np.ndarray:
    """One frame's four pictures with a line of text, uint8 (H, W, 3)."""
    completion = ilf.complete(frame)
    levels = robust_depth_levels(completion.depth)
    measured, filled = (depth_colours()[to_indices(depth, *levels)] for depth in (frame.depth, completion.depth))
    wrong = np.where(frame.missing, np.abs(completion.depth - frame.ground_truth) / WORST, np.nan)
    heat = cv2.applyColorMap(np.uint8(255 * np.clip(np.nan_to_num(wrong), 0, 1)), cv2.COLORMAP_INFERNO)[..., ::-1]
    error = np.where(np.isfinite(wrong)[..., None], heat, 225).astype(np.uint8)
    shown = [block_overlay(frame.rgb, ilf.extract_blocks(frame)), measured, filled, error]
    small = [cv2.resize(one, _SIZE, interpolation=cv2.INTER_AREA) for one in shown]
    found = evaluate_completion(frame, completion)
    median, mae, rmse = (f"{1000 * metres:.0f} mm" for metres in (found.median, found.mae, found.rmse))
    errors = f"median {median}, MAE {mae}, RMSE {rmse}"
    text = f"{frame.name}: {frame.missing_share:.0%} missing; errors of what is filled: {errors}"
    pictures = np.hstack([np.pad(one, ((0, 0), (0, _GAP), (0, 0)), constant_values=255) for one in small])
    line = np.full((_LINE, pictures.shape[1], 3), 255, np.uint8)
    cv2.putText(line, text, (2, 19), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (30, 30, 30), 1, cv2.LINE_AA)
    return np.vstack([line, pictures])


def main() -> None:
    """Complete both frames and write the picture if it has changed."""
    picture = np.vstack([row(desk()), row(ilf.load_frame(asset_path("samples/room"), name="The bundled sample"))])
    coded = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1]
    before = cv2.imread(str(PICTURE))
    if before is None or before.shape != picture.shape or cv2.absdiff(before, cv2.imdecode(coded, 1)).mean() > _VISIBLE:
        PICTURE.write_bytes(coded.tobytes())
        print(f"{PICTURE} has changed.")


if __name__ == "__main__":
    main()

"""A run over the small frame, and what it writes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

import ilf
from ilf.data.by_hand import DepthByHand
from ilf.run.options import ExportOptions
from ilf.run.writing import write
from ilf.segmentation.editing.patches import border_pixels

from .small_frames import CAMERA, QUICK, write_small_frame

OPTIONS = ExportOptions(cloud="xyz", axes="y-up", cloud_unit="mm")


def small_run(folder: Path, **changes: object) -> ilf.Run:
    """A quick run over the small frame, which is written into `folder`/in."""
    frame = ilf.load_frame(*write_small_frame(folder / "in"), intrinsics=CAMERA)
    return replace(ilf.Run.of(frame, preset=ilf.preset(**QUICK)), **changes)


def drawn(run: ilf.Run) -> ilf.Run:
    """The same run with a block that was drawn by hand."""
    labels = run.blocks.labels.copy()
    labels[5:30, 30:50] = 40_000
    return replace(run, blocks=replace(run.blocks, labels=labels))


def with_invalid_mask(run: ilf.Run) -> ilf.Run:
    """The same run with some depth distrusted, its blocks extracted without it."""
    mask = np.zeros(run.frame.shape, bool)
    mask[44:56, 4:20] = True
    return ilf.Run.of(run.frame.with_invalid_mask(mask), preset=run.parameters, extraction=run.blocks.extraction)


def with_drawn_border(run: ilf.Run) -> ilf.Run:
    """The same run, of which the right border of block 1 was drawn by hand, without any new label map."""
    drawn = border_pixels(run.blocks.labels) & (run.blocks.labels == 1)
    return replace(run, blocks=replace(run.blocks, drawn=drawn))


def with_depth_by_hand(run: ilf.Run) -> ilf.Run:
    """The same run with depth by hand in both holes, and a little where depth is known, which counts nowhere."""
    depth = np.full(run.frame.shape, np.nan, np.float32)
    depth[22:30, 8:62] = 1.75
    return replace(run, blocks=replace(run.blocks, by_hand=DepthByHand(depth, 0.6)))


def written(run: ilf.Run, folder: Path, options: ExportOptions = OPTIONS) -> Path:
    """Run it and write its files; returns the path of its record."""
    write(folder, run.complete(), options)
    return folder / "run.json"


def changed(path: Path, *keys_and_value: object) -> Path:
    """Write a record again with the value at some keys replaced."""
    *keys, last, value = keys_and_value
    data = part = json.loads(path.read_text())
    for key in keys:
        part = part[key]
    part[last] = value
    path.write_text(json.dumps(data))
    return path


def contents(folder: Path) -> dict[str, bytes]:
    """File name -> content."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}

"""Valid files that the program itself stores: runs, batches, and unsaved work."""

import dataclasses
import json
from pathlib import Path

import numpy as np

import ilf
from ilf.batch.engine import complete_frame
from ilf.batch.folder_sink import FolderSink
from ilf.batch.frames import frames_of_sources
from ilf.batch.settings import BatchSettings, sha256_of, write_settings
from ilf.data.guide import Guide
from ilf.data.presets import presets_folder
from ilf.project.store import WorkFolder
from ilf.run.options import ExportOptions
from ilf.run.run import BlockChoice
from ilf.run.writing import write
from tests.ilf.batch_frames import write_frames
from tests.ilf.project_states import small_frame

from . import seeds

_QUICK = {"max_iterations": 3, "edges": "canny", "correction": False}


def replay(folder: Path) -> list[bytes]:
    """Run record with a guide, masks and per-block parameters, and its files."""
    frame = small_frame(folder / "frame")
    mask = np.zeros(frame.shape, bool)
    mask[44:50, 4:10] = True
    drawn = np.zeros(frame.shape, bool)
    drawn[10:20, 39] = True
    guided = frame.with_invalid_mask(mask).with_guide(Guide(np.linspace(0.5, 4, frame.depth.size).reshape(frame.shape)))
    extraction, quick = ilf.BlockParameters(detector="canny"), ilf.preset(**_QUICK)
    contents = []
    for run in (ilf.Run.of(one, preset=quick, extraction=extraction) for one in (frame, guided)):
        own = {1: quick.replace(smoothness=2)}
        blocks = dataclasses.replace(run.blocks, drawn=None if run.frame is frame else drawn)
        run = dataclasses.replace(run, blocks=blocks).with_parameters(quick, own)
        write(folder / "out", run.complete(), ExportOptions(cloud=None))
        contents.append((folder / "out" / "run.json").read_bytes())
    return contents


def presets(folder: Path) -> list[bytes]:
    """Preset in the user's folder of presets."""
    presets_folder().mkdir()
    return seeds.preset(folder)


def batch(folder: Path) -> None:
    """The files in which a batch stores its progress."""
    settings = BatchSettings(
        ilf.preset(**_QUICK), BlockChoice(ilf.BlockParameters(detector="canny")), options=ExportOptions(cloud=None)
    )
    facts, levels = settings.facts(), (1.0, 3.0)
    frames = frames_of_sources([ilf.open_source(write_frames(folder / "frames", 1))])
    (folder / "sha256").write_text(sha256_of(facts))
    sink = FolderSink(settings=settings, folder=folder / "out", sha256=sha256_of(facts), levels=levels)
    (folder / "out").mkdir()
    write_settings(folder / "out", facts, levels)
    complete_frame(sink, frames[0], 1)


def autosave(folder: Path) -> list[bytes]:
    """The index of an autosave of two frames with all work on them; the other files are in `sound`."""
    seeds.project(folder)
    work = WorkFolder(folder / "sound")
    with ilf.open_project(folder / seeds.PROJECT) as opened:
        work.commit({name: opened.parts.read(name) for name in opened.parts.names()})
    work.close()
    return [(folder / "sound" / "index.json").read_bytes()]


def result(folder: Path) -> None:
    """A result with a pose, and its files."""
    frame = dataclasses.replace(small_frame(folder / "frame"), pose=np.eye(4))
    run = ilf.Run.of(frame, preset=ilf.preset(**_QUICK), extraction=ilf.BlockParameters(detector="canny"))
    write(folder / "out", run.complete(), ExportOptions(cloud=None))


def bench_frame(folder: Path) -> list[bytes]:
    """meta.json of a frame with ground truth and a hole."""
    (folder / "rgb.png").write_bytes(seeds.colour_png(folder)[0])
    (folder / "depth.png").rename(folder / "gt.png")
    (folder / "mask.png").write_bytes(seeds.mask(folder)[0])
    said = {"gt": "measured", "gt_units_per_m": 1000.0, "name": "made", "sensor": "none", "rgb": "rgb.png"}
    return [json.dumps(said).encode()]

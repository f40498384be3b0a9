"""Every format that the program reads: sound files of it, how they are made wrong, and how they are read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import ilf.trial
from ilf.cloud import point_cloud
from ilf.edges.importing import add_model
from ilf.errors import IlfError
from ilf.experiments.files import read_result
from ilf.io import intrinsics_from, list_frames, load_frame, load_guide, load_truth, read_blocks, read_labels
from ilf.io.frame_source import FrameSource
from ilf.io.label_files import read_mask
from ilf.io.nyu_labelled import NyuLabelled, read_split
from ilf.io.poses import camera_pose
from ilf.io.thumbnails import read_thumbnail
from ilf.models import models_folder
from ilf.preset_files import read_preset
from ilf.project.file import open_project, save_project
from ilf.run.record_file import read_record

from . import seeds
from .forked import run_forked
from .mutations import Mutation, of_bytes, of_json, of_png, of_text, of_zip

ilf.trial.run_apart = run_forked


@dataclass(frozen=True)
class Format:
    """A format of files.

    Attributes
    ----------
    name : str
    file : str
        Its name in the folder of a case, with what lies beside it.
    seeds : callable
        Writes what lies beside it into a folder; gives sound contents.
    mutate : callable
        Makes a wrong file of them.
    read : callable
        Reads it as the program does.
    """

    name: str
    file: str
    seeds: seeds.Seeds
    mutate: Mutation
    read: Callable[[Path], object]


def _depth(path: Path) -> None:
    frame = load_frame(path.parent / "rgb.png", path)
    assert np.isfinite(frame.depth[frame.known]).all()


def _colour(path: Path) -> None:
    load_frame(path, path.parent / "depth.png")


def _thumbnail(path: Path) -> None:
    read_thumbnail(FrameSource(str(path), "depth.png"))


def _folder(path: Path) -> None:
    frame = load_frame(path.parent)
    if frame.intrinsics is not None:
        points = point_cloud(frame.depth, frame.rgb, frame.intrinsics).points
        assert np.isfinite(points).all(), "points that are nowhere"


def _guide(path: Path) -> None:
    load_guide(path, seeds.SHAPE)


def _intrinsics(path: Path) -> None:
    intrinsics_from(path, seeds.SHAPE)


def _blocks(path: Path) -> None:
    found = read_blocks(path, seeds.SHAPE, image=path.parent / "rgb.png")
    assert found.labels.shape == seeds.SHAPE


def _project(path: Path) -> None:
    with open_project(path) as opened:
        for frame in opened.project.frames:
            try:
                opened.state(frame.id)
            except IlfError:
                continue
        save_project(path.with_name("again.ilf"), opened.project, base=[opened.parts], places=opened.places)


def _listed(path: Path) -> None:
    for source in list_frames(path.parent).sources[:2]:
        source.load()


def _trajectory(path: Path) -> None:
    camera_pose(path.parent / "depth" / "0.5.png")


def _pose(path: Path) -> None:
    camera_pose(path.parent / "frame-000000.depth.png")


def _network(path: Path) -> None:
    try:
        add_model(path, "fuzzed", replace=True)
    except IlfError:
        assert not (models_folder() / "fuzzed.onnx").exists(), "a refused network was written"
        raise
    (models_folder() / "fuzzed.onnx").unlink()


def _labelled(path: Path) -> None:
    with NyuLabelled(path) as file:
        for index in range(min(len(file), 2)):
            file.frame(index)
            file.filled(index)


def _for_member(name: str) -> Mutation:
    return of_json if name.endswith(".json") else of_bytes


_ALL = (
    Format("depth-png", "depth.png", seeds.depth_png, of_png, _depth),
    Format("depth-tiff", "depth.tif", seeds.depth_tiff, of_bytes, _depth),
    Format("depth-pgm", "depth.pgm", seeds.depth_pgm, of_bytes, _depth),
    Format("depth-npy", "depth.npy", seeds.depth_npy, of_bytes, _depth),
    Format("colour-png", "rgb.png", seeds.colour_png, of_png, _colour),
    Format("colour-jpeg", "rgb.jpg", seeds.colour_jpeg, of_bytes, _colour),
    Format("colour-ppm-tiff", "rgb.tif", seeds.colour_ppm, of_bytes, _colour),
    Format("thumbnail", "rgb.png", seeds.colour_png, of_png, _thumbnail),
    Format("guide-npz", "guide.npz", seeds.guide_npz, of_zip(lambda name: of_bytes), _guide),
    Format("truth-npy", "gt.npy", seeds.depth_npy, of_bytes, lambda path: load_truth(path, seeds.SHAPE)),
    Format("meta-json", "meta.json", seeds.meta_json, of_json, _folder),
    Format("intrinsics-json", "camera.json", seeds.intrinsics_json, of_json, _intrinsics),
    Format("preset", "preset.json", seeds.preset, of_json, read_preset),
    Format("blocks-coco", "blocks.json", seeds.blocks("coco"), of_json, _blocks),
    Format("blocks-coco-rle", "blocks.json", seeds.blocks("coco-rle"), of_json, _blocks),
    Format("blocks-labelme", "blocks.json", seeds.blocks("labelme"), of_json, _blocks),
    Format("label-map", "labels.png", seeds.label_map, of_png, lambda path: read_labels(path, seeds.SHAPE)),
    Format("mask", "mask.png", seeds.mask, of_png, lambda path: read_mask(path, seeds.SHAPE)),
    Format("project", "room.ilf", seeds.project, of_zip(_for_member), _project),
    Format("run-record", "run.json", seeds.record, of_json, read_record),
    Format("experiment", "sphere.json", seeds.experiment, of_json, read_result),
    Format("time-list", "rgb.txt", seeds.time_lists, of_text, _listed),
    Format("associations", "associations.txt", seeds.associations, of_text, _listed),
    Format("bop", "scene_camera.json", seeds.bop, of_json, _listed),
    Format("sun-camera", "intrinsics.txt", seeds.sun, of_text, _listed),
    Format("trajectory", "groundtruth.txt", seeds.trajectory, of_text, _trajectory),
    Format("pose", "frame-000000.pose.txt", seeds.pose, of_text, _pose),
    Format("onnx", "net.onnx", seeds.onnx, of_bytes, _network),
    Format("caffemodel", "hed.caffemodel", seeds.caffemodel, of_bytes, _network),
    Format("keras-hdf5", "hed.h5", seeds.keras, of_bytes, _network),
    Format("split-mat", "splits.mat", seeds.split, of_bytes, read_split),
    Format("nyu-labelled", "nyu.mat", seeds.nyu_labelled, of_bytes, _labelled),
)

FORMATS = {form.name: form for form in _ALL}

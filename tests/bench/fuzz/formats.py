"""Every format that the program reads: valid files, mutations, and readers."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ilf.batch.cluster import scheduler_address
from ilf.batch.pictures import read_preview
from ilf.data.presets import read_preset
from ilf.io.frame_additions import read_ground_truth
from ilf.io.images import read_colour, read_labels, read_mask
from ilf.run.record import read_record

from . import program_seeds, readers, recording_seeds, seeds
from .mutations import Mutation, of_bytes, of_json, of_png, of_sql, of_text, of_zip


@dataclass(frozen=True)
class Format:
    """A format of files.

    Attributes
    ----------
    name : str
    file : str
        Name of the file in the folder of a case.
    seeds : callable
        Writes companion files into a folder; returns valid contents, unless it writes the file itself.
    mutate : callable
        Makes a damaged file from these.
    read : callable
        Reads the file as the program does.
    """

    name: str
    file: str
    seeds: seeds.Seeds
    mutate: Mutation
    read: Callable[[Path], object]


def _for_member(name: str) -> Mutation:
    return of_json if name.endswith((".json", "metadata")) else of_bytes


_ALL = (
    Format("depth-png", "depth.png", seeds.depth_png, of_png, readers.depth),
    Format("depth-tiff", "depth.tif", seeds.depth_tiff, of_bytes, readers.depth),
    Format("depth-pgm", "depth.pgm", seeds.depth_pgm, of_bytes, readers.depth),
    Format("depth-npy", "depth.npy", seeds.depth_npy, of_bytes, readers.depth),
    Format("colour-png", "rgb.png", seeds.colour_png, of_png, readers.colour),
    Format("colour-jpeg", "rgb.jpg", seeds.colour_jpeg, of_bytes, readers.colour),
    Format("colour-heic", "rgb.heic", seeds.colour_heic, of_bytes, readers.photo),
    Format("colour-ppm-tiff", "rgb.tif", seeds.colour_ppm, of_bytes, readers.colour),
    Format("thumbnail", "rgb.png", seeds.colour_png, of_png, readers.thumbnail),
    Format("guide-npz", "guide.npz", seeds.guide_npz, of_zip(lambda name: of_bytes), readers.guide),
    Format("truth-npy", "gt.npy", seeds.depth_npy, of_bytes, lambda path: read_ground_truth(path, seeds.SHAPE)[0]),
    Format("meta-json", "meta.json", seeds.meta_json, of_json, readers.folder),
    Format("intrinsics-json", "camera.json", seeds.intrinsics_json, of_json, readers.intrinsics),
    Format("intrinsics-yaml", "camera.yaml", seeds.intrinsics_yaml, of_text, readers.intrinsics),
    Format("preset", "preset.json", seeds.preset, of_json, read_preset),
    Format("blocks-coco", "blocks.json", partial(seeds.blocks, format="coco"), of_json, readers.blocks),
    Format("blocks-coco-rle", "blocks.json", partial(seeds.blocks, format="coco-rle"), of_json, readers.blocks),
    Format("blocks-labelme", "blocks.json", partial(seeds.blocks, format="labelme"), of_json, readers.blocks),
    Format("label-map", "labels.png", seeds.label_map, of_png, lambda path: read_labels(path, seeds.SHAPE)),
    Format("mask", "mask.png", seeds.mask, of_png, lambda path: read_mask(path, seeds.SHAPE)),
    Format("project", seeds.PROJECT, seeds.project, of_zip(_for_member), readers.project),
    Format("run-record", "out/run.json", seeds.record, of_json, read_record),
    Format("time-list", "rgb.txt", seeds.time_lists, of_text, readers.listed),
    Format("associations", "associations.txt", seeds.associations, of_text, readers.listed),
    Format("bop", "scene_camera.json", seeds.bop, of_json, readers.listed),
    Format("sun-camera", "intrinsics.txt", seeds.sun, of_text, readers.listed),
    Format("trajectory", "groundtruth.txt", seeds.trajectory, of_text, readers.trajectory),
    Format("pose", "frame-000000.pose.txt", seeds.pose, of_text, readers.pose),
    Format("onnx", "net.onnx", seeds.onnx, of_bytes, readers.network),
    Format("nyu-labelled", "nyu.mat", seeds.nyu_labelled, of_bytes, readers.recording),
    Format("depth-exr", "depth.exr", recording_seeds.depth_exr, of_bytes, readers.depth),
    Format("depth-pfm", "depth.pfm", recording_seeds.depth_pfm, of_bytes, readers.depth),
    Format("depth-colmap", "depth.bin", recording_seeds.depth_colmap, of_bytes, readers.depth),
    Format("depth-hdf5", "depth.hdf5", seeds.depth_hdf5, of_bytes, readers.depth),
    Format("depth-hdf5-named", "depth.h5", seeds.depth_of_several, of_bytes, readers.dataset),
    Format("depth-raw", "depth.raw", seeds.viewer, of_bytes, readers.depth),
    Format("depth-raw-table", "depth_metadata.csv", seeds.viewer, of_text, readers.viewer_table),
    Format("depth-pcd", "depth.pcd", seeds.depth_pcd, of_bytes, readers.depth),
    Format("colour-pcd", "depth.pcd", seeds.depth_pcd, of_bytes, read_colour),
    Format("depth-pclzf", "depth.pclzf", seeds.depth_pclzf, of_bytes, readers.depth),
    Format("layout", "layout.toml", seeds.layout, of_text, readers.layout),
    Format("transforms", "transforms/transforms.json", seeds.transforms, of_json, readers.folder_around),
    Format("trajectory-log", "frames/trajectory.log", seeds.open3d_trajectory, of_text, readers.folder_around),
    Format("intrinsics-text", "camera.txt", seeds.intrinsics_text, of_text, readers.intrinsics),
    Format("depth-npz", "depth.npz", recording_seeds.depth_npz, of_zip(lambda name: of_bytes), readers.depth),
    Format("ros1-bag", "made.bag", recording_seeds.bag("ros1"), of_bytes, readers.recording),
    Format("ros2-sqlite", "made.db3", recording_seeds.bag("sqlite3"), of_bytes, readers.recording),
    Format("ros2-sqlite-sql", "made.db3", recording_seeds.bag("sqlite3"), of_sql, readers.recording),
    Format("ros2-mcap", "made.mcap", recording_seeds.bag("mcap"), of_bytes, readers.recording),
    Format("azure-mkv", "made.mkv", recording_seeds.azure, of_bytes, readers.recording),
    Format("record3d", "made.r3d", recording_seeds.record3d, of_zip(_for_member), readers.recording),
    Format("scannet-sens", "made.sens", recording_seeds.scannet, of_bytes, readers.recording),
    Format("stray-video", "stray/rgb.mp4", recording_seeds.stray, of_bytes, readers.folder_around),
    Format("stray-odometry", "stray/odometry.csv", recording_seeds.stray, of_text, readers.folder_around),
    Format("stray-camera", "stray/camera_matrix.csv", recording_seeds.stray, of_text, readers.folder_around),
    Format("arkit-camera", recording_seeds.ARKIT_CAMERA, recording_seeds.arkit, of_text, readers.arkit_camera),
    Format("arkit-poses", "4242/lowres_wide.traj", recording_seeds.arkit, of_text, readers.folder_around),
    Format("ros2-metadata", "made/metadata.yaml", recording_seeds.ros2, of_text, readers.folder_around),
    Format("realsense-bag", "made.bag", recording_seeds.realsense_viewer, of_bytes, readers.recording),
    Format("realsense-db3", "made.db3", recording_seeds.realsense_library, of_bytes, readers.recording),
    Format("realsense-db3-sql", "made.db3", recording_seeds.realsense_library, of_sql, readers.recording),
    Format("nyu-raw-colour", "raw/r-1.5-1.ppm", recording_seeds.nyu_raw, of_bytes, readers.unregistered),
    Format("nyu-raw-depth", "raw/d-1.5-2.pgm", recording_seeds.nyu_raw, of_bytes, readers.unregistered),
    Format("raw-pair", "pair/calibration.json", recording_seeds.raw_pair, of_json, readers.folder_around),
    Format("file-names", "names.txt", seeds.names, of_text, readers.names),
    Format("guide-npy", "guide.npy", seeds.guide_npy, of_bytes, readers.guide),
    Format("guide-png", "guide.png", seeds.guide_png, of_png, readers.guide),
    Format("guide-pfm", "guide.pfm", recording_seeds.depth_pfm, of_bytes, readers.guide),
    Format("guide-exr", "guide.exr", recording_seeds.depth_exr, of_bytes, readers.guide),
    Format("truth-png", "gt.png", seeds.depth_png, of_png, lambda path: read_ground_truth(path, seeds.SHAPE)[0]),
    Format("confidence-png", "sure.png", seeds.confidence_png, of_png, readers.confidence),
    Format("confidence-npy", "sure.npy", seeds.confidence_npy, of_bytes, readers.confidence),
    Format("mask-folder", "masks/1.png", seeds.mask_picture, of_png, readers.masks),
    Format("preset-folder", "PRESETS/own.json", program_seeds.presets, of_json, readers.presets),
    Format("replay", "out/run.json", program_seeds.replay, of_json, readers.replayed),
    Format("result-record", "out/run.json", program_seeds.result, of_json, readers.result),
    Format("result-meta", "out/meta.json", program_seeds.result, of_json, readers.result),
    Format("bench-frame", "meta.json", program_seeds.bench_frame, of_json, readers.bench_frame),
    Format("batch-settings", "out/batch.json", program_seeds.batch, of_json, readers.batch),
    Format("batch-frame", "out/rgb__0000/frame.json", program_seeds.batch, of_json, readers.batch),
    Format("batch-preview", "out/preview.png", seeds.colour_png, of_png, lambda path: read_preview(path.parent)),
    Format("scheduler-file", "scheduler.json", seeds.scheduler, of_json, lambda path: scheduler_address(str(path))),
    Format("window-settings", "ILF Studio/ilf-studio.ini", seeds.window, of_text, readers.window),
    Format("autosave", "left.work/index.json", program_seeds.autosave, of_json, readers.autosave),
)

FORMATS = {form.name: form for form in _ALL}

"""Writing of a run: the selected result files, the record and meta.json; all of them or none."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import file_sha256, read_json
from .._runtime.formatting import counted
from .._runtime.long_work import cancellable_items, check_cancelled
from .._runtime.schema import PROGRAM
from .._runtime.writing import check_writable, move_into_place, staging, write_bytes
from ..completion.confidence.expected_error import expected_error, unsupported
from ..completion.confidence.model import default_edges
from ..data.camera import REMEDY
from ..data.flying_points import flying_points
from ..data.frame import FrameInputs, RGBDFrame
from ..data.points import in_world, point_cloud
from ..data.results import Completion
from ..data.surface import surface_mesh, surface_normals
from ..errors import ExportError, IlfError, InputError
from ..io.clouds import write_cloud
from ..io.depth import encode_depth, encode_expected_error, encode_npy, precision_loss
from ..io.images import encode_image, encode_labels, encode_mask
from ..io.meshes import write_mesh
from ..sources.frame_ref import RECORD_FILE
from ..sources.naming import META_NAME
from ..sources.registration import aligned
from . import files
from .curves import encode_curves
from .formats import FORMATS, Content, Export, Made, check_format, colour_seen_from
from .options import (
    ALIGNED_FILES,
    CLOUD_FILES,
    DEPTH_FILES,
    ERROR_FILES,
    MESH_FILES,
    WORLD,
    ExportOptions,
)
from .record import make_record, to_json
from .run import Run

# Point cloud and mesh of a run's result, with values per point.


def check_cloud_and_mesh(frame: RGBDFrame, options: ExportOptions) -> None:
    """Raise InputError for a cloud or a mesh of a frame without intrinsics, or in world axes without a pose."""
    if options.axes == WORLD and frame.pose is None and (options.cloud or options.mesh):
        raise InputError("The pose of this frame's camera is not known: select axes other than world.")
    if frame.intrinsics is None and (options.cloud or options.mesh):
        what = "point cloud" if options.cloud else "mesh"
        raise InputError(f"A {what} needs the camera's intrinsics. {REMEDY} Or leave the {what} out.")


def drop_impossible_cloud(
    options: ExportOptions, frame: RGBDFrame, remedy: str = ""
) -> tuple[ExportOptions, tuple[str, ...]]:
    """Remove the cloud from the options if the frame has no intrinsics; returns options and a note that ends with the
    remedy."""
    if frame.intrinsics is not None or options.cloud is None:
        return options, ()
    note = f"No point cloud is written, because the camera's intrinsics are not known{remedy}."
    return replace(options, cloud=None), (note,)


def write_cloud_and_mesh(folder: Path, completion: Completion, options: ExportOptions) -> list[str]:
    """Write the selected cloud and mesh; returns notes.

    Parameters
    ----------
    folder : Path
    completion, options
        As for `write`; the frame's camera is known.
    """
    frame, depth = completion.frame, completion.depth
    camera, rgb = frame.intrinsics, frame.rgb
    if camera is None or not (options.cloud or options.mesh):
        return []
    notes = []
    only = ~flying_points(depth, camera) if options.drop_flying else None
    if only is not None and (count := np.count_nonzero(~only)):
        notes.append(f"Left out of cloud and mesh: {counted(count, 'flying point')}. The depth files contain them.")
    if options.normals and options.cloud in {"xyz", "xyzrgb"}:
        notes.append(f"{CLOUD_FILES[options.cloud]} cannot store normals: select PLY or PCD.")
    known: dict[str, Any] = {
        "only": only,
        "normals": surface_normals(depth, camera) if options.normals else None,
        "scalars": _scalars(completion, options),
    }
    pose = frame.pose if options.axes == WORLD else None
    axes = options.axes if pose is None else "camera"
    if options.cloud is not None:
        cloud = point_cloud(depth, rgb, camera, **known)
        if pose is not None:
            cloud = in_world(cloud, pose)
        path = folder / CLOUD_FILES[options.cloud]
        write_cloud(path, cloud, axes=axes, unit=options.cloud_unit, ascii=options.cloud == "ply-ascii")
        del cloud  # the mesh is as large
        check_cancelled()
    if options.mesh is not None:
        mesh = surface_mesh(depth, rgb, camera, **known)
        check_cancelled()
        if pose is not None and options.mesh != "glb":
            mesh = replace(mesh, vertices=in_world(mesh.vertices, pose))
        write_mesh(folder / MESH_FILES[options.mesh], mesh, axes=axes, unit=options.cloud_unit)
    return notes


def _scalars(completion: Completion, options: ExportOptions) -> dict[str, NDArray[Any]]:
    """Scalar values of every pixel for the cloud and the mesh."""
    run = completion.run
    scalars = {
        "expected_error": expected_error(completion) if options.expected_error else None,
        "filled": completion.filled,
        "block": run.blocks.labels,
        "from_neighbours": None if run.frame.from_neighbours is None else completion.from_neighbours,
        "by_hand": None if run.blocks.by_hand is None else completion.by_hand,
        "unsupported": unsupported(completion) if options.expected_error else None,
    }
    return {name: values for name, values in scalars.items() if values is not None}


_DEPTH_PREFERENCE = ("npy", "tiff", "png")
"""Depth formats in which the folder is opened again as a frame, the most accurate first."""


@dataclass(frozen=True)
class Written:
    """The result of writing a run.

    Attributes
    ----------
    files : tuple of Path
        In the order of `filenames`.
    notes : tuple of str
        What the user should know of the files: what they do not preserve, and how to keep it; what of the depth is
        extrapolated or unsupported.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def filenames(run: Run | None, options: ExportOptions) -> tuple[str, ...]:
    """Names of the files that `write` writes, without a run those of any; its record, which completes the set, is the
    last."""
    return tuple(contents(run, options))


def contents(run: Run | None, options: ExportOptions) -> dict[str, Content | None]:
    """Return what makes each file that `write` writes, by its name as in `filenames`: None for cloud, mesh, meta.json
    and the record, which are made of several parts."""
    formats, units = options.depth_formats, options.depth_units
    made: dict[str, Content | None] = {DEPTH_FILES[one]: partial(_depth, DEPTH_FILES[one], units) for one in formats}
    if options.expected_error and formats:
        made |= {ERROR_FILES[one]: partial(_error, ERROR_FILES[one], units) for one in formats}
        made[files.UNSUPPORTED] = lambda completion, image: (encode_mask(unsupported(completion)), ())
    if options.labels:
        made[files.LABELS] = lambda completion, image: (encode_labels(completion.run.blocks.labels), ())
    if options.curves:
        made[files.CURVES] = lambda completion, image: (encode_curves(completion.history), ())
    if options.cloud is not None:
        made[CLOUD_FILES[options.cloud]] = None
    if options.mesh is not None:
        made[MESH_FILES[options.mesh]] = None
    made |= {FORMATS[name].file: FORMATS[name].content for name in options.exports}
    if run is not None:
        if run.frame.brought is not None:
            made |= {ALIGNED_FILES[one]: partial(_aligned, ALIGNED_FILES[one], units) for one in formats}
        made |= {name: partial(_array, name) for name in _arrays(run)}
        if run.frame.inputs is not None and formats:
            made |= {META_NAME: None} if run.frame.inputs.has_colour_file else {files.COLOUR: colour, META_NAME: None}
    if options.run_record:
        made[RECORD_FILE] = None
    return made


def colour(completion: Completion, image: str) -> Made:
    """The colour of a completion as PNG."""
    return encode_image(".png", completion.frame.rgb[..., ::-1]), ()  # the encoder expects BGR


def _depth(name: str, units: float, completion: Completion, image: str) -> Made:
    return encode_depth(name, completion.depth, units)


def _error(name: str, units: float, completion: Completion, image: str) -> Made:
    return encode_expected_error(name, expected_error(completion), units)


def _aligned(name: str, units: float, completion: Completion, image: str) -> Made:
    return encode_depth(name, aligned(completion.depth, completion.frame), units)[0], ()  # the notes are those of depth


def _array(name: str, completion: Completion, image: str) -> Made:
    array = _arrays(completion.run, completion)[name]
    return (encode_mask if array.dtype == np.bool_ else encode_npy)(array), ()


def write(
    folder: str | os.PathLike[str],
    completion: Completion,
    options: ExportOptions | None = None,
    *,
    overwrite: bool = True,
) -> Written:
    """Write the selected files of a completion into a folder: all of them, or none.

    `run.json` is written last and contains the SHA-256 of the others: without it, or with other files, the set is
    incomplete. `meta.json` makes the folder a frame that can be opened again, with the completed depth; for a frame of
    a recording, the colour is written as well. In the depth camera's view, depth is also written aligned to colour.

    Parameters
    ----------
    folder : path-like
        Created if missing. Other files in it are not changed.
    completion : Completion
    options : ExportOptions, optional
        The defaults if left out.
    overwrite : bool
        Whether files of an earlier export may be replaced.

    Returns
    -------
    Written

    Raises
    ------
    InputError
        If a cloud or a mesh is selected and the frame has no intrinsics. Nothing is written then.
    ExportError
        If a file would replace one of the frame's own, or cannot be written. The folder is unchanged then.

    Examples
    --------
    >>> import tempfile, ilf
    >>> import numpy as np
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, intrinsics=(30, 30, 15, 10))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = write(folder, ilf.complete(frame))
    >>> [path.name for path in written.files][:2]
    ['depth.png', 'depth.npy']
    """
    run, chosen, target = completion.run, options or ExportOptions(), Path(folder).absolute()
    check_write(target, run, chosen, overwrite=overwrite)
    made = contents(run, chosen)
    names = tuple(made)
    image = colour_path(target, run, chosen) if chosen.exports else ""
    notes = list(_notes(completion, chosen))
    with staging(target) as staged:
        for name, make in cancellable_items(list(made.items())):
            if make is not None:
                content, found = make(completion, image)
                write_bytes(staged / name, content)
                notes += [f"{name}: {note}" for note in found]
        notes += write_cloud_and_mesh(staged, completion, chosen)
        if META_NAME in names and run.frame.inputs is not None:
            write_bytes(staged / META_NAME, _meta(run.frame, run.frame.inputs, chosen))
        if chosen.run_record:
            outputs = {name: file_sha256(staged / name) for name in cancellable_items(names) if name != RECORD_FILE}
            record = dataclasses.replace(make_record(completion, chosen), outputs=outputs)
            write_bytes(staged / RECORD_FILE, to_json(record))
            if run.blocks.edited and not chosen.labels:
                notes.append(f"{RECORD_FILE} cannot be replayed without {files.LABELS}: the blocks were edited.")
        if names:
            move_into_place(staged, target, names)
    return Written(tuple(target / name for name in names), tuple(notes))


def save(
    folder: str | os.PathLike[str], completion: Completion, options: ExportOptions | None, **changes: Any
) -> Written:
    """Write a completion as `Completion.save` does."""
    chosen, notes = (options or ExportOptions()).replace(**changes), tuple[str, ...]()
    if options is None and "cloud" not in changes:
        chosen, notes = drop_impossible_cloud(chosen, completion.frame, ": make the frame with intrinsics=")
    written = write(folder, completion, chosen)
    return replace(written, notes=(*notes, *written.notes))


def export(path: str | os.PathLike[str], completion: Completion) -> tuple[str, ...]:
    """Write a completion as `Completion.export` does."""
    chosen = Export(path)
    check_not_an_input(completion.frame, [chosen.path])
    return tuple(chosen.write(completion))


def check_write(
    folder: str | os.PathLike[str],
    run: Run,
    options: ExportOptions,
    *,
    overwrite: bool = True,
    given: Sequence[str | os.PathLike[str]] = (),
) -> None:
    """Check before a long run whether its results can be written.

    Parameters
    ----------
    folder, run, options, overwrite
        As for `write`.
    given : sequence of path-like
        Other input files and folders of the run, which must not be overwritten either.

    Raises
    ------
    InputError, ExportError
        As for `write`.
    """
    target, frame = Path(folder), run.frame
    check_cloud_and_mesh(frame, options)
    for name in options.exports:
        check_format(name, run)
    check_writable(target)
    paths = [target / name for name in filenames(run, options)]
    check_not_an_input(frame, paths, given)
    meta = target / META_NAME
    if meta in paths and os.path.isfile(meta) and not _is_export_meta(meta):
        raise ExportError(f"{meta} describes a frame, not an export, and would be overwritten. Choose another folder.")
    for path in paths:
        if os.path.isdir(path):
            raise ExportError(f"{path} is a folder, but a file of that name must be written. Choose another folder.")
        if os.path.exists(path) and not overwrite:
            raise ExportError(f"{path} already exists. Choose another folder, or allow overwriting.")


def drop_impossible(options: ExportOptions, run: Run) -> tuple[ExportOptions, tuple[str, ...]]:
    """Remove from the options what cannot be made of a run; returns options and notes."""
    kept, notes = drop_impossible_cloud(options, run.frame)
    lacks = {name: why for name in options.exports if (why := FORMATS[name].lacks(run))}
    exports = tuple(name for name in options.exports if name not in lacks)
    return replace(kept, exports=exports), (*notes, *(f"No {name} is written. {why}" for name, why in lacks.items()))


def check_not_an_input(frame: RGBDFrame, paths: Sequence[Path], given: Sequence[str | os.PathLike[str]] = ()) -> None:
    """Raise ExportError if a path is a file that the frame was read from, or may have been, or is one of `given`."""
    others = [Path(path) for path in given if os.path.exists(path)]
    others += [inside for path in others if path.is_dir() for inside in path.iterdir()]
    for path in _same_files(paths, others):
        raise ExportError(f"{path} is an input of this run and would be overwritten. Choose another folder.")
    if frame.inputs is None:
        return
    inputs = list(map(Path, frame.files))
    for path in _same_files(paths, [*inputs, *(path.with_name(META_NAME) for path in inputs)]):
        raise ExportError(f"{path} is the frame's own file and would be overwritten. Choose another folder.")


def _same_files(paths: Sequence[Path], sources: Sequence[Path]) -> list[Path]:
    """The paths that are the same file as one of the sources."""
    there = [source for source in sources if os.path.exists(source)]
    return [path for path in paths if os.path.exists(path) and any(path.samefile(source) for source in there)]


def colour_path(folder: Path, run: Run, options: ExportOptions) -> str:
    """Return the path of the colour file as seen from the results in a folder; "" for none."""
    return files.COLOUR if files.COLOUR in filenames(run, options) else colour_seen_from(folder, run.frame)


def _notes(completion: Completion, options: ExportOptions) -> Iterator[str]:
    """Yield what the user should know of the files as a whole."""
    run = completion.run
    if run.extrapolate and (count := np.count_nonzero(completion.extrapolated)):
        yield f"Extrapolated, not completed by a block: {counted(count, 'pixel')}, see {files.EXTRAPOLATED}."
    given = options.depth_units if run.frame.inputs is None else run.frame.inputs.depth_units
    if "png" in options.depth_formats and (coarser := precision_loss(given, options.depth_units)):
        yield f"{DEPTH_FILES['png']}: {coarser}"
    if not (options.expected_error and (options.depth_formats or options.cloud or options.mesh)):
        return
    yield from (note for note in default_edges(run.frame).notes if note not in completion.notes)
    if options.depth_formats and (count := np.count_nonzero(unsupported(completion) & ~completion.extrapolated)):
        yield f"Unsupported by measurements: {counted(count, 'pixel')}, see {files.UNSUPPORTED}."


def _arrays(run: Run, completion: Completion | None = None) -> dict[str, NDArray[Any]]:
    """File name -> array: the inputs of a run beside colour and depth, and masks of its result, which are empty without
    a completion."""
    frame, by_hand, none = run.frame, run.blocks.by_hand, np.zeros(0, bool)
    arrays = {
        files.EXTRAPOLATED: (none if completion is None else completion.extrapolated) if run.extrapolate else None,
        files.INVALID_MASK: frame.invalid_mask,
        files.DRAWN: run.blocks.drawn,
        files.OUTSIDE: frame.outside_view,
        files.FROM_NEIGHBOURS: frame.from_neighbours,
        files.DEPTH_BY_HAND: None if by_hand is None else by_hand.depth,
        files.BY_HAND: None if by_hand is None else none if completion is None else completion.by_hand,
        files.GUIDE: None if frame.guide is None else frame.guide.array,
    }
    return {name: array for name, array in arrays.items() if array is not None}


def _is_export_meta(meta: Path) -> bool:
    """Whether a meta.json was written by an export."""
    try:
        content = read_json(meta)
    except IlfError:
        return False
    return isinstance(content, dict) and content.get("program") == PROGRAM


def _meta(frame: RGBDFrame, inputs: FrameInputs, options: ExportOptions) -> bytes:
    """Content of meta.json, which makes the folder a frame: the completed depth, and the path of the colour."""
    depth_format = next(known for known in _DEPTH_PREFERENCE if known in options.depth_formats)
    camera = frame.intrinsics
    meta = {
        "program": PROGRAM,
        "name": f"{frame.name}-completed",
        "size": [frame.shape[1], frame.shape[0]],
        "rgb": inputs.rgb.path if inputs.has_colour_file else files.COLOUR,
        "depth": DEPTH_FILES[depth_format],
        "depth_units_per_m": options.depth_units if depth_format == "png" else 1.0,
        "K": None if camera is None else camera.numbers,
        "run": RECORD_FILE if options.run_record else None,
        **({} if frame.pose is None else {"pose": frame.pose.tolist()}),
        **({} if frame.outside_view is None else {"outside_view": files.OUTSIDE}),
    }
    return f"{json.dumps(meta, indent=2)}\n".encode()

"""Replay of a run record: the same frame, blocks and parameters, and a comparison of the results."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import file_sha256, is_address
from .._runtime.formatting import counted
from .._runtime.installation import __version__
from .._runtime.networks.models import CORRECTION, SPARSE_CORRECTION
from .._runtime.networks.network import device
from .._runtime.schema import Section
from ..completion.block import BlockTask
from ..completion.correction import needs_correction
from ..data.blocks import Block, Blocks, find_blocks
from ..data.by_hand import DepthByHand
from ..data.frame import InputFile, RGBDFrame
from ..data.guide import Guide
from ..data.neighbours import Neighbour, NeighbourDepth
from ..data.parameters import Parameters
from ..data.presets import preset
from ..data.results import BlockOutcome, BlockResult, Completion, History, compose
from ..errors import IlfError, InputError
from ..io.depth import read_depth_values
from ..io.encodings import encoding_of
from ..io.frame_additions import ground_truth_of, load_guide
from ..io.images import read_labels, read_mask
from ..segmentation.edges.frame_edges import edge_parameters
from ..segmentation.extraction import found_blocks
from ..sources.frame_ref import FrameRef
from ..sources.named_places import NotAllowed, first_allowed, note_opened
from ..sources.neighbours import seen_by
from ..sources.reading import read_frame
from . import files
from .curves import read_curves
from .options import DEPTH_FILES, ExportOptions
from .record import (
    RecordedMask,
    RunRecord,
    array_sha256,
    installed_sha256,
    library_versions,
    processor,
    read_record,
    requested_networks,
)
from .run import Run

# Differences from the recorded state: files, edge networks, versions and processor.


def file_problems(record: RunRecord, folder: Path) -> tuple[str, ...]:
    """Check a record's set of files; one sentence each for files that are missing and files that have changed.

    Parameters
    ----------
    record : RunRecord
    folder : Path
        Folder of the record.
    """
    gone = [name for name in record.outputs if not os.path.isfile(folder / name)]
    changed = [
        name for name, sha256 in record.outputs.items() if name not in gone and file_sha256(folder / name) != sha256
    ]
    sentences = []
    if gone:
        sentences.append(f"The set of files is incomplete: missing {', '.join(gone)}.")
    if changed:
        has = "has" if len(changed) == 1 else "have"
        sentences.append(f"{', '.join(changed)} {has} changed since the run was written.")
    return tuple(sentences)


def setup_differences(record: RunRecord) -> str:
    """Text on the program, libraries, processor and device of the networks that differ from the record; "" if all are
    the same."""
    recorded = {"ilf": record.version, **record.versions, "processor": record.processor, "device": record.device}
    present = {"ilf": __version__, **library_versions(), "processor": processor(), "device": device()}
    return ", ".join(
        f"{name} {was} (here {present[name]})"
        for name, was in recorded.items()
        if name in present and was != present[name]
    )


def network_differences(record: RunRecord) -> list[str]:
    """Sentences on networks that differ from the record, and the consequences."""
    sentences = []
    for user, networks, result in (
        ("extraction", record.networks.extraction, "blocks"),
        ("filter", record.networks.filter, "depth"),
    ):
        for name, sha256 in networks.items():
            present = installed_sha256(name)
            if present != sha256:
                state = "is not available" if present is None else "has changed"
                means = f"the {result} may differ. Install the recorded one"
                sentences.append(f"The network {name!r} used by the {user} {state}: {means}.")
    return sentences


_ROUNDING = 1e-4
"""Difference [m] above that of rounding on another processor or library, where up to 6e-6 m was measured."""


@dataclass(frozen=True, eq=False)
class Replay:
    """A recorded run, ready to be executed again.

    Attributes
    ----------
    run : Run
    options : ExportOptions
    record : RunRecord
    differences : tuple of str
        Differences from the recorded state and their consequences; one sentence each.
    """

    run: Run
    options: ExportOptions
    record: RunRecord
    differences: tuple[str, ...]
    _folder: Path
    _depth: NDArray[np.float32] | None

    @cached_property
    def completion(self) -> Completion | None:
        """The recorded completion, from the files beside the record; None if it is not there in full: without lossless
        depth (`depth.npy` or `depth.tiff`), or with files that have changed."""
        return recorded_completion(self.run, self.record, self._folder, self._depth)

    def verdict(self, completion: Completion) -> tuple[str, ...]:
        """Compare the results of the run with the recorded ones; empty if they are equal bit for bit.

        Parameters
        ----------
        completion : Completion
            Result of `run`.

        Returns
        -------
        tuple of str
            One sentence each, with the size of the differences if the recorded depth is available.
        """
        if self.record.depth_sha256 == array_sha256(completion.depth):
            return ()
        if self._depth is None:
            return (
                "The depth is not bit for bit the recorded one. The difference cannot be computed: the original "
                f"{DEPTH_FILES['npy']} or {DEPTH_FILES['tiff']} is not beside the record.",
            )
        return (f"{depth_difference_text(completion.depth, self._depth)}.",)


def depth_difference_text(depth: NDArray[np.float32], recorded: NDArray[np.float32]) -> str:
    """Text on the difference of depth [m] from the recorded depth, both (H, W)."""
    both = np.isfinite(depth) & np.isfinite(recorded)
    apart = np.abs(depth[both].astype(np.float64) - recorded[both])
    largest = float(apart.max(initial=0.0))
    other = int(np.count_nonzero(np.isfinite(depth) != np.isfinite(recorded)))
    different = counted(int(np.count_nonzero(apart)), "pixel")
    text = f"The depth differs from the recorded one by up to {largest:.1e} m, at {different}"
    if other:
        return f"{text}; in addition, {counted(other, 'pixel')} missing in only one of them"
    return f"{text}: within rounding, the results are the same" if largest < _ROUNDING else text


def replay(
    path: str | os.PathLike[str],
    rgb: str | os.PathLike[str] | None = None,
    depth: str | os.PathLike[str] | None = None,
    *,
    extract: bool = True,
) -> Replay:
    """Load and check all inputs of a recorded run.

    Parameters
    ----------
    path : path-like
        The run.json. Label map, guide, depth by hand, masks (invalid depth, drawn borders, outside view), and input
        files, also of neighbours, that have been moved are searched beside it.
    rgb, depth : path-like, optional
        New paths of the input files; for a frame of a recording, `rgb` is that of the recording. Ground truth and
        neighbours are also searched beside them.
    extract : bool
        Whether extracted blocks are extracted again, and compared. False takes the recorded ones from the label map
        beside the record if it is there, which is faster.

    Returns
    -------
    Replay
        Its `run` has the recorded inputs, even if they have been moved, so that its record is the same.

    Raises
    ------
    InputError
        If there is no such record, an input file, also of a neighbour, is missing, is not the recorded one, or lies
        where nothing is opened unasked (see `ilf.sources.allow_address`), or the blocks, the guide, depth by hand or
        one of the masks cannot be restored.
    FormatError
        If the record cannot be read.

    Examples
    --------
    >>> import tempfile, ilf
    >>> from ilf._runtime.installation import asset_path
    >>> frame = ilf.load_frame(asset_path("samples/room"))
    >>> completion = ilf.complete(frame, np.ones(frame.shape, int), "paper", max_iterations=5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = completion.save(folder, expected_error=False)
    ...     again = ilf.replay(Path(folder) / "run.json")
    >>> np.array_equal(again.run.blocks, completion.blocks), again.differences
    (True, ())
    """
    record, folder = read_record(path), Path(path).absolute().parent
    frame = _recorded_frame(record, folder, rgb, depth)
    places = [folder, *(Path(path).absolute().parent for path in (rgb, depth) if path is not None)]
    frame = _with_recorded_neighbours(record, frame, places)
    frame, without_ground_truth = _with_recorded_ground_truth(record, frame, places)
    differences = [
        *without_ground_truth,
        *file_problems(record, folder),
        *network_differences(record),
    ]
    blocks = _recorded_blocks(record, frame, folder, extract)
    gone = sorted(set(record.own_parameters) - set(np.unique(blocks.labels).tolist()))
    if gone:
        raise InputError(f"The record was changed: its label map lacks blocks of its outcomes, {gone}. Restore it.")
    if others := setup_differences(record):
        differences.append(f"The run was made with {others}: results may differ in the last digits, or more.")
    run = Run(frame, blocks, record.parameters, frozenset(record.own_parameters), record.extrapolate)
    return Replay(run, record.export, record, tuple(differences), folder, recorded_depth(record, folder))


def _recorded_frame(
    record: RunRecord,
    folder: Path,
    rgb: str | os.PathLike[str] | None,
    depth: str | os.PathLike[str] | None,
) -> RGBDFrame:
    inputs = record.inputs
    if inputs is None:
        raise InputError("This run cannot be replayed: its frame was not read from files. Save it, and run it again.")
    note_opened(rgb, depth)
    is_whole = inputs.frame is None
    colour = _place_of(inputs.rgb, "colour file" if is_whole else "recording", [folder], rgb, is_whole)
    found = _place_of(inputs.depth, "depth file", [folder], depth) if is_whole else None
    ref = replace(FrameRef.of(replace(inputs, ground_truth=None)), rgb=str(colour), depth=found and str(found))
    frame = read_frame(ref, name=record.name, beside=False)
    read = frame.inputs
    if read is None or (read.rgb.sha256, read.depth.sha256) != (inputs.rgb.sha256, inputs.depth.sha256):
        if inputs.frame is not None:
            raise InputError(f"{colour} is not the run's recording: frame {inputs.frame} differs. Give the original.")
        raise InputError("The run's colour or depth file has changed. Try again, or give the original files.")
    pose = frame.pose if record.pose is None else np.array(record.pose)
    frame = replace(frame, inputs=replace(inputs, ground_truth=None), pose=pose)
    if record.outside_view is not None:
        outside = _beside(record.outside_view, "the mask of the outside view", folder)
        frame = replace(frame, outside_view=outside)
    values, stated = _beside(record.guide, "the guide", folder, lambda path: load_guide(path).array), record.guide
    if values is not None and stated is not None:
        guide = replace(Guide.from_array(values, stated.path), network=stated.network, gives=stated.gives)
        frame = frame.with_guide(guide)
    return frame.with_invalid_mask(_beside(record.invalid_mask, "the mask of invalid depth", folder))


def _with_recorded_neighbours(record: RunRecord, frame: RGBDFrame, folders: Sequence[Path]) -> RGBDFrame:
    """The frame with the depth of the recorded neighbours, read again."""
    if not record.neighbours:
        return frame
    layers = [seen_by(frame, _recorded_neighbour(one, folders), np.array(one.motion)) for one in record.neighbours]
    return frame.with_neighbours(NeighbourDepth(np.stack(layers), record.neighbours))


def _recorded_neighbour(recorded: Neighbour, folders: Sequence[Path]) -> RGBDFrame:
    """A neighbour from its files, at their recorded paths or in one of the folders."""
    if not recorded.source:
        raise InputError(f"It cannot be replayed: its neighbour {recorded.name} was not read from files. Run it again.")

    def present(path: str) -> str:
        paths = path, *(str(folder / _file_name(path)) for folder in folders)
        sha256 = hashes.get(path, "")
        return first_allowed(paths, folders[0], lambda one: is_address(one) or os.path.exists(one), sha256) or path

    source = FrameRef.from_json(Section("neighbour", dict(recorded.source)), "")
    hashes = {} if source.depth is None else dict(zip((source.rgb, source.depth), recorded.sha256, strict=False))
    try:
        source = replace(source.with_paths(present, cameras=True), stated_in=None)
        frame = read_frame(source)
    except NotAllowed:
        raise
    except IlfError as error:
        raise InputError(f"The neighbour {recorded.name} of the recorded run cannot be read. {error}") from error
    if frame.inputs is None or (frame.inputs.rgb.sha256, frame.inputs.depth.sha256) != recorded.sha256:
        raise InputError(f"{source.depth or source.rgb} is not the neighbour {recorded.name} of the run. Restore it.")
    return frame


def _with_recorded_ground_truth(
    record: RunRecord, frame: RGBDFrame, folders: Sequence[Path]
) -> tuple[RGBDFrame, tuple[str, ...]]:
    """The frame with the recorded ground truth, or unchanged with a sentence on why; no depth depends on it."""
    recorded = None if record.inputs is None else record.inputs.ground_truth
    if recorded is None:
        return frame, ()
    try:
        found = _place_of(recorded, "ground-truth file", folders)
        ground_truth, _, _ = ground_truth_of(frame, found, recorded.units, recorded.dataset)
        return frame.with_ground_truth(ground_truth, recorded), ()
    except NotAllowed:
        raise
    except InputError as error:
        return frame, (f"The run is not evaluated against ground truth, and its curves have no error. {error}",)


def _place_of(
    recorded: InputFile,
    what: str,
    folders: Sequence[Path],
    given: str | os.PathLike[str] | None = None,
    is_whole: bool = True,
) -> str:
    """A file of the run: the given one, at its recorded path, or in one of the folders, that of the record first.
    `is_whole`: its recorded hash is that of the whole file, which it has then, but for one at an address, which is
    compared when it has been read."""

    def is_it(path: str) -> bool:
        if is_address(path):
            return True
        return os.path.isfile(path) and file_sha256(path) == recorded.sha256 if is_whole else os.path.exists(path)

    first = recorded.path if given is None else os.fspath(given)
    if given is None:
        paths = first, *(str(folder / _file_name(first)) for folder in folders)
        found = first_allowed(paths, folders[0], is_it, recorded.sha256 if is_whole else "")
    else:
        found = first if is_it(first) else None
    if found is not None:
        return found
    # a file of that name beside the record may be one of its outputs
    if is_whole and os.path.isfile(first):
        raise InputError(f"{first} is not the {what} of the recorded run: its content has changed. Give the original.")
    told = f"{first}: there is no such file, but it is the {what} of the recorded run"
    raise InputError(f"{told}. Put it beside the record, or give the frame's new path.")


def _file_name(path: str) -> str:
    """The last part of a path of any operating system."""
    return re.split(r"[\\/]", path)[-1]


def _beside(
    recorded: RecordedMask | None, what: str, folder: Path, read: Callable[[Path], NDArray[Any]] = read_mask
) -> NDArray[Any] | None:
    """An array that the run was given, from its file beside the record; None if it was given none."""
    if recorded is None:
        return None
    path = folder / recorded.file
    if not os.path.isfile(path):
        raise InputError(f"{what.capitalize()} of this run ({path.name}) is not beside the record. Put it there.")
    array = read(path)
    if array_sha256(array) != recorded.sha256:
        raise InputError(f"{path} is not {what} of the recorded run: its content has changed. Restore it.")
    return array


def _recorded_blocks(record: RunRecord, frame: RGBDFrame, folder: Path, extract: bool) -> Blocks:
    """The recorded blocks: extracted again, or with the label map from the file beside the record."""
    drawn = _beside(record.drawn, "the mask of drawn borders", folder)
    by_hand = _beside(record.by_hand, "depth by hand", folder, read_depth_values)
    return replace(
        _found_again(record, frame, folder, extract).with_parameters(record.own_parameters, record.parameters),
        drawn=drawn,
        by_hand=None if record.by_hand is None or by_hand is None else DepthByHand(by_hand, record.by_hand.weight),
    )


def _found_again(record: RunRecord, frame: RGBDFrame, folder: Path, extract: bool) -> Blocks:
    network, saved = next(iter(record.networks.extraction.values()), None), _saved_labels(record, folder)
    if record.extraction is None or record.blocks.edited:
        if saved is None:
            raise InputError(
                "The blocks of this run were drawn or edited by hand, and their label map "
                f"({record.blocks.file or files.LABELS}) is not beside the record or has changed. Restore it there."
            )
        return Blocks(saved, extraction=record.extraction, network=network)
    if saved is not None and not extract:
        return Blocks(saved, extraction=record.extraction, network=network, extracted=saved)
    again = found_blocks(frame, record.extraction)
    if array_sha256(again.labels) == record.blocks.sha256:
        return again
    others = setup_differences(record)
    problem = "The extraction gives different blocks than recorded" + (f" with {others}" if others else "")
    name = record.blocks.file or files.LABELS
    if saved is None:
        remedy = f"{problem}. Install the recorded versions, or put the run's {name} beside the record."
        raise InputError(" ".join((*again.notes, remedy)))
    notes = *again.notes, f"{problem}; those of {name} are used."
    return replace(again, labels=saved, extracted=saved, network=network, notes=notes)


def _saved_labels(record: RunRecord, folder: Path) -> NDArray[np.int32] | None:
    """The label map beside the record; None if it is missing or not the recorded one."""
    if record.blocks.file is None or not os.path.isfile(folder / record.blocks.file):
        return None
    labels = read_labels(folder / record.blocks.file)
    matches = labels.shape == record.blocks.shape and array_sha256(labels) == record.blocks.sha256
    return labels if matches else None


# The completion of a recorded run, from the files beside its record instead of another run.


def recorded_depth(record: RunRecord, folder: Path) -> NDArray[np.float32] | None:
    """The recorded depth [m], (H, W), from a lossless file beside the record; None if there is none."""
    for name in (DEPTH_FILES["npy"], DEPTH_FILES["tiff"]):
        if _is_as_written(record, folder, name):
            return encoding_of(1.0).metres(read_depth_values(folder / name))
    return None


def recorded_completion(
    run: Run, record: RunRecord, folder: Path, depth: NDArray[np.float32] | None
) -> Completion | None:
    """The completion of a recorded run with its recorded depth; None if the files beside the record do not give it.

    Its curves have no seconds, and none at all without the file of the curves.
    """
    if depth is None or depth.shape != run.frame.shape:
        return None
    extrapolated = np.zeros(depth.shape, bool)
    if record.extrapolate:
        if not _is_as_written(record, folder, files.EXTRAPOLATED):
            return None
        extrapolated = read_mask(folder / files.EXTRAPOLATED, depth.shape)
    of_blocks = np.where(extrapolated, np.float32(np.nan), depth)
    curves = read_curves(folder / files.CURVES) if _is_as_written(record, folder, files.CURVES) else {}
    blocks = find_blocks(run.blocks.labels, run.only)
    results = {
        outcome.label: _result(run, record, blocks[outcome.label], outcome, of_blocks, curves.get(outcome.label, ()))
        for outcome in record.blocks_outcome
    }
    completion = compose(run, results)
    if record.extrapolate:
        completion = replace(
            completion,
            depth=np.where(extrapolated, depth, completion.depth),
            filled=completion.filled | extrapolated,
            extrapolated=extrapolated,
            extrapolation_network=_network(record, preset()),
        )
    return completion if array_sha256(completion.depth) == record.depth_sha256 else None


def _is_as_written(record: RunRecord, folder: Path, name: str) -> bool:
    path = folder / name
    return name in record.outputs and os.path.isfile(path) and file_sha256(path) == record.outputs[name]


def _result(
    run: Run, record: RunRecord, block: Block, outcome: BlockOutcome, depth: NDArray[np.float32], history: History
) -> BlockResult:
    """The result of a block, with what its run had; a block that was not iterated on has no network."""
    parameters = record.own_parameters[outcome.label]
    task = BlockTask.of(run.frame, block, parameters, run.blocks)
    edges = edge_parameters(parameters, task.extraction)
    found = depth[block.box][block.mask]
    result = BlockResult(block, found, outcome, history, parameters, edges=edges, drawn=task.drawn)
    if not outcome.iterations:
        return result
    used = (record.networks.filter.get(name) for name in (CORRECTION, SPARSE_CORRECTION))
    correction = tuple(sha256 for sha256 in used if sha256 is not None) if needs_correction(result) else ()
    return replace(result, network=_network(record, parameters), correction=correction, by_hand=task.by_hand)


def _network(record: RunRecord, parameters: Parameters) -> str | None:
    """SHA-256 of the recorded edge network that these parameters use; None if they use none."""
    if parameters.filter != "edge-aware":
        return None
    names = requested_networks(parameters.edges, parameters.model)
    return next((record.networks.filter[name] for name in names if name in record.networks.filter), None)

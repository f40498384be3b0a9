"""Facts that `ilf info` shows: collected one by one, printed as lines or as one JSON object; of a run record
and of a frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import with_dataset
from ..data.camera import Camera, camera_text
from ..data.frame import RGBDFrame
from ..data.lenses import undistorted
from ..data.parameters import BlockParameters, nearest_preset
from ..errors import InputError
from ..io import frame_additions as additions
from ..io.cameras import frame_camera, intrinsics_from
from ..io.depth_doubts import DepthReading
from ..io.encodings import encoding_of_inputs
from ..io.images import read_colour_with_warning
from ..run.record import RunRecord, read_record
from ..run.replaying import file_problems
from ..run.writing import filenames
from ..sources.copies import copied
from ..sources.frame_folder import FrameFiles
from ..sources.frame_ref import COMPLETED_DEPTH, RECORD_FILE, FrameRef, ReadingOptions, is_result, is_result_folder
from ..sources.naming import META_NAME
from ..sources.read_images import ReadImages, depth_of_files, is_registered, read_files, read_recorded
from ..sources.reading import files_of, read_frame
from .output import fact_lines, outcome_lines, outcome_record, parameters_text, values_text


class Facts:
    """All facts about a source, a frame or a run.

    Parameters
    ----------
    kind : str
        Its key in the JSON document.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._lines: list[tuple[str, str]] = []
        self.entries: dict[str, Any] = {}
        """Of the JSON document."""
        self.table: Sequence[str] = ()
        """Lines below the others."""

    def add(self, name: str, text: str, /, **entries: Any) -> None:
        """Add a line, and its entries in the JSON document."""
        self._lines.append((name, text))
        self.entries |= entries

    def add_camera(self, name: str, camera: Camera | None) -> None:
        """Add a camera, whose entry has its name."""
        self.add(name, camera_text(camera), **{name.replace(" ", "_"): None if camera is None else camera.to_json()})

    def tell(self, kind: str, *texts: str) -> None:
        """Add lines of a kind: "warning" (of plausibility), "note" or "problem"; no line for an empty text."""
        self._lines += [(kind, text) for text in texts if text]

    @contextmanager
    def problems(self) -> Iterator[None]:
        """Within the block, an input that cannot be read is a problem, which ends the block."""
        try:
            yield
        except InputError as error:
            self.tell("problem", str(error))

    def told(self, kind: str) -> list[str]:
        """The texts of a kind."""
        return [text for name, text in self._lines if name == kind]

    def record(self) -> dict[str, Any]:
        """Return the facts for the JSON document."""
        lists = {"plausibility_warnings": "warning", "notes": "note", "problems": "problem"}
        return self.entries | {name: self.told(kind) for name, kind in lists.items()}

    def lines(self) -> list[str]:
        """Format the facts as lines."""
        return fact_lines(self._lines) + (["", *self.table] if self.table else [])


def facts_of_record(path: Path) -> Facts:
    """List the facts about the run record at a path."""
    record, facts = read_record(path), Facts("run")
    versions = ", ".join(f"{name} {version}" for name, version in record.versions.items())
    facts.add("made with", f"ILF Studio {record.version}, {versions}", version=record.version, versions=record.versions)
    _add_inputs(facts, record)
    height, width = record.blocks.shape
    origin = "given as a label map" if record.extraction is None else "edited" if record.blocks.edited else "extracted"
    text = f"{len(record.blocks_outcome)} run, {width} x {height}, {origin}"
    facts.add("blocks", text, width=width, height=height, blocks_from=origin)
    if record.extraction is not None:
        changes = record.extraction.differences_from(BlockParameters())
        facts.add("extraction", values_text(changes) or "defaults", extraction=changes)
    preset, values = nearest_preset(record.parameters).preset, record.parameters.to_dict()
    facts.add("parameters", parameters_text(record.parameters), preset=preset, parameters=values)
    for label, changes in record.block_parameters.items():
        facts.add(f"block {label}", values_text(changes), block_parameters=record.block_parameters)
    _add_networks(facts, record)
    _add_files(facts, record)
    if record.neighbours:
        names = [neighbour.name for neighbour in record.neighbours]
        facts.add("neighbours", ", ".join(names), neighbours=names)
    if record.extrapolate:
        facts.add("extrapolated", "depth that was still missing after the run", extrapolated=True)
    files = list(record.outputs or filenames(None, record.export))
    facts.add("files", ", ".join(files), files=files)
    facts.tell("problem", *file_problems(record, path.absolute().parent))
    facts.entries["blocks"] = [outcome_record(outcome) for outcome in record.blocks_outcome]
    facts.table = outcome_lines(record.blocks_outcome)
    return facts


def _add_inputs(facts: Facts, record: RunRecord) -> None:
    """Add the files that the run has read."""
    inputs = record.inputs
    if inputs is None:
        facts.add("frame", "not read from files; the run cannot be replayed")
        return
    encoding = encoding_of_inputs(inputs).text
    facts.add("colour", inputs.rgb.path, colour=inputs.rgb.path)
    facts.add("depth", with_dataset(inputs.depth.path, inputs.dataset), depth=inputs.depth.path)
    facts.add("encoding", encoding, encoding=encoding)
    facts.add_camera("intrinsics", intrinsics_from(inputs.intrinsics))
    if inputs.view is not None:
        facts.add("view", "of the depth camera", view=inputs.view)
    if inputs.frame is not None:
        facts.add("frame", inputs.frame, frame=inputs.frame)
    if (truth := inputs.ground_truth) is not None:
        stated = {"path": truth.path, "units_per_m": truth.units}
        facts.add("ground truth", f"{truth.named}, {truth.units:g} units per metre", ground_truth=stated)


def _add_networks(facts: Facts, record: RunRecord) -> None:
    """Add the networks that were used, and for what."""
    uses = (record.networks.extraction, "blocks"), (record.networks.filter, "the filter")
    used = dict.fromkeys(item for networks, _ in uses for item in networks.items())
    for name, sha256 in used:
        use = " and ".join(text for networks, text in uses if networks.get(name) == sha256)
        facts.add("network", f"{name} ({sha256[:12]}) for {use}", networks=dict(used))


def _add_files(facts: Facts, record: RunRecord) -> None:
    """Add what was given besides the frame, and is stored with the run."""
    if record.invalid_mask is not None:
        facts.add("invalid mask", record.invalid_mask.file, invalid_mask=record.invalid_mask.file)
    if record.drawn is not None:
        facts.add("borders", record.drawn.file, borders=record.drawn.file)
    if (by_hand := record.by_hand) is not None:
        stated = {"file": by_hand.file, "weight": by_hand.weight}
        facts.add("depth by hand", f"{by_hand.file}, weight {by_hand.weight:g}", depth_by_hand=stated)
    if (guide := record.guide) is not None:
        origin = "" if guide.path is None else f", read from {guide.path}"
        network = None if guide.network is None else guide.network.name
        origin = f", predicted by {network}" if network else origin
        facts.add(
            "guide", f"in {guide.file}{origin}", guide={"file": guide.file, "path": guide.path, "network": network}
        )


# Of a frame: its colour, depth, cameras, and what belongs to it; what cannot be read is a problem.

_Depth = NDArray[np.float32]


def facts_of_frame(ref: FrameRef, given: ReadingOptions) -> Facts:
    """List the facts about a frame, read with the options of the user."""
    given = given.of_frame
    ref = replace(ref, options=given.or_else(ref.options))
    if ref.frame is not None:
        return _facts_of_recorded(ref)
    facts, frame = Facts("frame"), None
    with copied(ref) as here:
        files = files_of(here)
        files = replace(files, options=here.options.or_else(files.options))
        facts.add("name", files.name, name=files.name)
        if is_result_folder(here):
            facts.add("result", f"completed depth, not measured; its run is in {RECORD_FILE}", result=RECORD_FILE)
        depth = depth_of_files(files, given)
        _add_colour(facts, files.rgb)
        _add_depth(facts, with_dataset(files.depth, files.options.dataset), depth)
        if is_result(FrameRef(str(files.rgb), str(files.depth))):
            facts.tell("note", f"{files.depth.name}: {COMPLETED_DEPTH}")
        # one that cannot be read is an error, not a problem of the pair
        stated = (files.options.depth_intrinsics, files.options.intrinsics)
        cameras = [frame_camera(camera, None)[0] for camera in stated]
        with facts.problems():
            images = read_files(files, given, depth=depth)
            frame = images.frame()
            _add_frame(facts, frame, images, files.options)
        if frame is None:
            facts.add_camera("intrinsics", cameras[0] or cameras[1])
        _add_ground_truth(facts, files, depth, frame)
        _add_guide(facts, files.options, depth.metres if frame is None else frame.measured)
        _add_confidence(facts, files.options.confidence, files.options.min_confidence, depth.metres)
    return facts


def _facts_of_recorded(ref: FrameRef) -> Facts:
    """List the facts about a frame of a recording."""
    frame, images, facts = read_frame(ref), read_recorded(ref.allowed()), Facts("frame")
    depth, (height, width) = images.reading, frame.shape
    facts.add("name", frame.name, name=frame.name)
    facts.add("colour", f"{ref.rgb}, {width} x {height}", colour=ref.rgb, width=width, height=height)
    _add_depth(facts, ref.rgb, depth)
    facts.add_camera("intrinsics", frame.intrinsics)
    _add_registered(facts, frame)
    if images.confidence is not None:
        _add_confidence(facts, images.confidence, ref.options.min_confidence, depth.metres)
    _tell_notes(facts, frame, depth)
    return facts


def facts_of_colour(path: Path) -> Facts:
    """List the facts about a colour image alone."""
    facts = Facts("frame")
    _add_colour(facts, path)
    return facts


def _add_colour(facts: Facts, path: Path) -> None:
    rgb, doubt = read_colour_with_warning(path)
    height, width = rgb.shape[:2]
    facts.add("colour", f"{path}, {width} x {height}", colour=str(path), width=width, height=height)
    facts.tell("warning", doubt)


def _add_frame(facts: Facts, frame: RGBDFrame, images: ReadImages, options: ReadingOptions) -> None:
    """Add what a frame of two files is, besides these."""
    cameras, how = images.cameras, ""
    is_same = is_registered(options, images.rgb.shape[:2], images.metres.shape)
    if not is_same:
        is_colour = frame.brought is not None
        facts.add_camera(*("colour camera", cameras.colour) if is_colour else ("depth camera", cameras.depth))
        apart = 0 if cameras.depth_to_colour is None else 1000 * float(np.linalg.norm(cameras.depth_to_colour[:3, 3]))
        place = f"{apart:.0f} mm apart" if apart else "as seen from the same place"
        how = f"on reading, by the intrinsics of both images, {place}: "
    facts.add_camera("intrinsics", frame.intrinsics)
    if how or options.undistort:
        _add_registered(facts, frame, how)
    _tell_notes(facts, frame, images.reading)


def _add_registered(facts: Facts, frame: RGBDFrame, how: str = "") -> None:
    """Add what a frame is whose pixels are not those of its depth file, or of its colour file."""
    outside = f", {frame.outside_share:.1%} outside the depth camera's view" if frame.outside_share else ""
    shares = {"missing_share": frame.missing_share, "outside_view_share": frame.outside_share}
    facts.add("registered", f"{how}{frame.missing_share:.1%} missing{outside}", **shares)
    if frame.brought is not None:
        seen = float(frame.brought.seen.mean())
        facts.add("view", f"of the depth camera; colour sees {seen:.1%} of its pixels", view="depth", colour_share=seen)


def _tell_notes(facts: Facts, frame: RGBDFrame, depth: DepthReading) -> None:
    """Tell the notes on a frame that are not yet told of its colour and depth."""
    told = {*depth.notes, *facts.told("warning")}
    for text in frame.notes:
        if text not in told:
            facts.tell("warning" if text in frame.plausibility_warnings else "note", text)


def _add_depth(facts: Facts, path: str, depth: DepthReading) -> None:
    values, metres = depth.values, depth.metres
    known = metres[np.isfinite(metres)]
    height, width = values.shape
    size = {"depth_width": width, "depth_height": height, "depth_type": str(values.dtype)}
    facts.add("depth", f"{path}, {width} x {height}, {values.dtype}", depth=str(path), **size)
    encoding, assumed = depth.encoding.text, depth.is_assumed
    how = " (assumed; set it with --depth-encoding)" if assumed else ""
    facts.add("encoding", f"{encoding}{how}", encoding=encoding, encoding_assumed=assumed)
    missing = 1 - known.size / metres.size
    facts.add("missing", f"{missing:.1%}", missing_share=missing)
    if known.size:
        low, high, median = float(known.min()), float(known.max()), float(np.median(known))
        text = f"{low:.3f} to {high:.3f} m, median {median:.3f} m"
        facts.add("range", text, min_m=low, max_m=high, median_m=median)
    facts.tell("left out", depth.left_out)
    facts.tell("warning", *(doubt.text for doubt in depth.plausibility_warnings))


def _add_ground_truth(facts: Facts, files: FrameFiles, reading: DepthReading, frame: RGBDFrame | None) -> None:
    options, depth = files.options, reading.metres if frame is None else frame.measured
    if options.ground_truth is None:
        if files.has_meta and (filled := sorted(files.rgb.parent.glob("gt.*"))):
            why = f"none: according to {META_NAME}, {filled[0].name} is not measured or exact depth"
            facts.add("ground truth", why)
        return
    with facts.problems():
        shape, encoding = (depth.shape[0], depth.shape[1]), reading.encoding
        truth, file, note = additions.read_ground_truth(
            options.ground_truth, shape, options.ground_truth_units, encoding.units, encoding.invalid
        )
        truth = truth if frame is None else undistorted(truth, frame)
        shares, text = _known_shares(truth, depth)
        entries = {"path": str(file.path), **shares, "units_per_m": file.units}
        facts.add("ground truth", f"{file.named}, {file.units:g} units per metre, {text}", ground_truth=entries)
        facts.tell("note", note)
        facts.tell("problem", additions.scale_misfit(truth, depth, file.units))


def _known_shares(values: NDArray[Any], depth: _Depth) -> tuple[dict[str, float], str]:
    """Return the known share of all pixels, and of the pixels with missing depth, 0-1, and both as text."""
    known, missing = np.isfinite(values), np.isnan(depth)
    share, of_missing = float(known.mean()), np.count_nonzero(known & missing) / max(int(np.count_nonzero(missing)), 1)
    text = f"known at {share:.1%} of all pixels and {of_missing:.1%} of the missing ones"
    return {"known_share": share, "known_share_of_missing": of_missing}, text


def _add_guide(facts: Facts, options: ReadingOptions, depth: _Depth) -> None:
    if options.guide is None:
        return
    with facts.problems():
        if additions.guide_network(options.guide, options.guide_gives):
            facts.add("guide", f"to be predicted by {options.guide}", guide={"path": options.guide})
            return
        guide = additions.load_guide(options.guide, (depth.shape[0], depth.shape[1]), gives=options.guide_gives)
        shares, text = _known_shares(guide.values, depth)
        facts.add("guide", f"{guide.path}, {text}", guide={"path": str(guide.path), **shares})


def _add_confidence(facts: Facts, given: str | NDArray[Any] | None, least: float | None, depth: _Depth) -> None:
    """Add confidence values, or those of a file, and what depth is below the minimum confidence."""
    if given is None:
        facts.tell("warning", "" if least is None else additions.NO_CONFIDENCE_MAP)
        return
    with facts.problems():
        path = given if isinstance(given, str) else None
        levels = additions.read_confidence(given, depth.shape) if isinstance(given, str) else given
        effect = additions.UNUSED_CONFIDENCE if least is None else additions.low_confidence(levels, least, depth)[1]
        low, high = float(levels.min()), float(levels.max())
        where = "" if path is None else f"{path}, "
        entries = {"path": path, "min": low, "max": high, "min_confidence": least}
        facts.add("confidence", f"{where}from {low:g} to {high:g}. {effect}", confidence=entries)
        facts.tell("warning", "" if least is None else additions.confidence_doubt(levels, least, depth))

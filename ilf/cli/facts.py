"""Facts that `ilf info` shows: collected one by one, printed as lines or as one JSON object; those of a run record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._runtime.files import with_dataset
from ..data.camera import Camera, camera_text
from ..data.parameters import BlockParameters, nearest_preset
from ..errors import InputError
from ..io.cameras import intrinsics_from
from ..io.encodings import encoding_of_inputs
from ..run.record import RunRecord, read_record
from ..run.replaying import file_problems
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
    files = list(record.outputs or record.export.filenames())
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

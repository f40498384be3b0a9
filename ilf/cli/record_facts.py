"""A run record in words, for `ilf info`."""

from __future__ import annotations

from collections.abc import Mapping

from ..camera import camera_text
from ..declarations import ParameterSet, Value
from ..io.camera_files import intrinsics_from
from ..io.encodings import encoding_of_inputs
from ..parameters import BlockParameters
from ..preset_words import likeness
from ..run import RunRecord


def record_facts(record: RunRecord) -> list[tuple[str, str]]:
    """What a run was made of, as pairs of name and fact."""
    facts = [
        ("made with", f"ILF Studio {record.version}, " + ", ".join(f"{k} {v}" for k, v in record.versions.items()))
    ]
    if record.inputs is None:
        facts.append(("frame", "not read from files, so the run cannot be replayed"))
    else:
        facts += [
            ("colour", record.inputs.rgb.path),
            ("depth", record.inputs.depth.path),
            ("encoding", encoding_of_inputs(record.inputs).text),
            ("intrinsics", camera_text(intrinsics_from(record.inputs.intrinsics))),
        ]
        if record.inputs.frame is not None:
            facts.append(("frame", record.inputs.frame))
        if record.inputs.truth is not None:
            facts.append(("truth", f"{record.inputs.truth.path}, {record.inputs.truth.units:g} units per metre"))
    origin = "given as a label map" if record.extraction is None else "edited" if record.edited else "extracted"
    facts.append(("blocks", f"{len(record.outcomes)} run, {record.shape[1]} x {record.shape[0]}, {origin}"))
    if record.extraction is not None:
        facts.append(("extraction", _changes(record.extraction, BlockParameters()) or "defaults"))
    nearest = likeness(record.common)
    changes = _text(nearest.differs)
    facts.append(("parameters", f"preset {nearest.preset}" + (f" with {changes}" if changes else "")))
    facts += [
        (f"block {label}", _changes(own, record.common))
        for label, own in record.parameters.items()
        if own != record.common
    ]
    uses = (record.extraction_networks, "blocks"), (record.networks, "the filter")
    for name, sha256 in dict.fromkeys(item for networks, _ in uses for item in networks.items()):
        use = " and ".join(text for networks, text in uses if networks.get(name) == sha256)
        facts.append(("network", f"{name} ({sha256[:12]}) for {use}"))
    if record.distrusted is not None:
        facts.append(("distrusted", f"depth in {record.distrusted.file}"))
    if record.drawn is not None:
        facts.append(("drawn", f"borders in {record.drawn.file}"))
    if record.guide is not None:
        origin = "" if record.guide.path is None else f", read from {record.guide.path}"
        facts.append(("guide", f"in {record.guide.file}{origin}"))
    if record.dense:
        facts.append(("dense", "the rest was guessed"))
    return [*facts, ("files", ", ".join(record.outputs or record.options.filenames()))]


def _changes(values: ParameterSet, base: ParameterSet) -> str:
    return _text(values.unlike(base))


def _text(values: Mapping[str, Value]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())

"""What is no longer as it was when a run was recorded: its files, the edge networks, versions and processor."""

from __future__ import annotations

import os
from pathlib import Path

from ..io.files import file_sha256
from ..models import CORRECTION, DEPTH_EDGES
from ..version import __version__
from .machine import library_versions, processor
from .networks import asked_networks, present_sha256
from .record import RunRecord


def missing_or_changed(record: RunRecord, folder: Path) -> tuple[str, ...]:
    """What is wrong with a record's set of files, a sentence each: files that are gone or have changed since.

    Parameters
    ----------
    record : RunRecord
    folder : Path
        Where it lies.
    """
    gone = [name for name in record.outputs if not os.path.isfile(folder / name)]
    changed = [
        name for name, sha256 in record.outputs.items() if name not in gone and file_sha256(folder / name) != sha256
    ]
    sentences = []
    if gone:
        sentences.append(f"The set is not whole: {', '.join(gone)} {'is' if len(gone) == 1 else 'are'} not beside it.")
    if changed:
        sentences.append(
            f"{', '.join(changed)} {'has' if len(changed) == 1 else 'have'} changed since the run was written: the "
            "record does not vouch for that."
        )
    return tuple(sentences)


def version_differences(record: RunRecord) -> str:
    """The program and libraries whose versions are not those of the record, in words; "" if all are the same."""
    recorded = {"ilf": record.version, **record.versions}
    present = {"ilf": __version__, **library_versions()}
    return ", ".join(
        f"{name} {version} (here {present[name]})"
        for name, version in recorded.items()
        if name in present and version != present[name]
    )


def processor_difference(record: RunRecord) -> str:
    """Another kind of processor than the record's, in words; "" if it is the same or not known."""
    if record.processor in {"", processor()}:
        return ""
    return f"another kind of processor ({record.processor}; here {processor()})"


def networks_that_were_missing(record: RunRecord) -> list[str]:
    """Edge networks that others' edges stood in for when the run was recorded, and that are here now."""
    if record.schema == 0:
        return []
    missed = set()
    if record.extraction is not None:
        asked = asked_networks(record.extraction.detector, record.extraction.model)
        missed.update(set(asked[:1]) - record.extraction_networks.keys())
    for outcome in record.outcomes:
        parameters = record.parameters[outcome.label]
        if parameters.filter == "edge-aware" and outcome.iterations:
            asked = asked_networks(parameters.edges, parameters.model)
            missed.update(set(asked[:1]) - record.networks.keys())
    return [
        f"When the run was recorded, the edge network {name!r} was missing or did not work, and other edges stood in "
        "for its own: blocks and depth may be others now that it is here."
        for name in sorted(missed)
        if present_sha256(name) is not None
    ]


def network_differences(record: RunRecord) -> list[str]:
    """Networks that are not those of the record, and what that means."""
    sentences = []
    parts = (
        (record.extraction_networks, "the blocks were extracted with", "the blocks may be others"),
        (record.networks, "the filter took its edges from", "depth beside edges may differ by more than rounding"),
    )
    for networks, had, means in parts:
        for name, sha256 in networks.items():
            present = present_sha256(name)
            if present == sha256:
                continue
            state = "is not here" if present is None else "is another one now"
            if name == CORRECTION:
                sentences.append(
                    f"The correction network that the depth was corrected with {state}: depth that was missing may be "
                    "other. Install the recorded version."
                )
                continue
            way_out = "Install the recorded version" if name == DEPTH_EDGES else "Import the recorded one"
            sentences.append(f"The edge network {name!r} that {had} {state}: {means}. {way_out}.")
    return sentences

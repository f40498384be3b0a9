"""The settings of a batch; batch.json stores them with the results, so that changed settings are noticed."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .._runtime.files import file_sha256, read_json
from .._runtime.installation import __version__
from .._runtime.networks.models import CORRECTION, SPARSE_CORRECTION
from .._runtime.schema import PROGRAM, Section, check_schema, json_file
from .._runtime.writing import write_bytes
from ..data.frame import RGBDFrame
from ..data.parameters import Parameters
from ..data.presets import preset
from ..errors import FormatError, InputError, told_as
from ..evaluation.hold_out import HoldOutTest
from ..io.images import read_mask
from ..run.options import ExportOptions
from ..run.record import installed_sha256, requested_networks
from ..run.run import BlockChoice, Run

SETTINGS_FILE = "batch.json"

SCHEMA = 1
"""Version of the format of batch.json and frame.json."""

Levels = tuple[float, float]


@dataclass(frozen=True)
class BatchSettings:
    """The settings that determine the results of a batch, besides its frames.

    Parameters
    ----------
    parameters : Parameters
    blocks : BlockChoice
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated.
    options : ExportOptions
        Files to write for each frame. Frames without intrinsics get no point cloud.
    hidden : HoldOutTest, optional
        Also evaluate each frame on hold-out.
    invalid_mask : str, optional
        Path of the mask of invalid depth, the same for every frame.
    steady : int
        For a static camera: number of frames before and after each that its temporal median includes
        (`with_temporal_median`). 0 for none.
    neighbours, neighbour_step : int
        Number of frames before and after each whose depth is added, and their distance (`with_neighbours`). 0 for none.
    """

    parameters: Parameters = field(default_factory=preset)
    blocks: BlockChoice = field(default_factory=BlockChoice)
    extrapolate: bool = False
    options: ExportOptions = field(default_factory=ExportOptions)
    hidden: HoldOutTest | None = None
    invalid_mask: str | None = None
    steady: int = 0
    neighbours: int = 0
    neighbour_step: int = 1

    def run_of(self, frame: RGBDFrame) -> Run:
        """Make the run of a frame; InputError if its blocks cannot be made, or the mask of invalid depth is of another
        size."""
        if self.invalid_mask is not None:
            frame = frame.with_more_invalid(read_mask(self.invalid_mask, frame.shape))
        return self.blocks.run_of(frame, self.parameters, self.extrapolate)

    def facts(self) -> dict[str, Any]:
        """Return all settings as JSON values; files and networks are represented by SHA-256. Includes the version.

        Raises
        ------
        InputError
            If one of the files cannot be read.
        """
        blocks = self.blocks
        files = {"blocks": blocks.file, "drawn": blocks.drawn, "invalid_mask": self.invalid_mask}
        facts = {
            "version": __version__,
            "parameters": self.parameters.to_dict(),
            "extraction": blocks.extraction.to_dict(),
            "extrapolate": self.extrapolate,
            "fill_gaps": blocks.fill_gaps,
            "files": {name: _content_sha256(path) for name, path in files.items() if path is not None},
            "export": dataclasses.asdict(self.options),
            "steady": self.steady,
            "hidden": None if self.hidden is None else dataclasses.asdict(self.hidden),
            "networks": {name: installed_sha256(name) for name in self._networks()},
            **({"neighbours": [self.neighbours, self.neighbour_step]} if self.neighbours else {}),
        }
        return dict(json.loads(json.dumps(facts)))  # as they are read back

    def _networks(self) -> list[str]:
        extraction, parameters = self.blocks.extraction, self.parameters
        asked = [*requested_networks(extraction.detector, extraction.model)] if self.blocks.file is None else []
        if parameters.filter == "edge-aware":
            asked += requested_networks(parameters.edges, parameters.model)
            asked += [CORRECTION, SPARSE_CORRECTION] if parameters.correction else []
        return sorted(set(asked))


def sha256_of(facts: Any) -> str:
    """Return the SHA-256 of JSON values; equal ones have equal hashes on all machines."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def read_settings(folder: Path) -> tuple[dict[str, Any], Levels] | None:
    """Read facts and colour range of the batch in a folder; None if there is none.

    Raises
    ------
    FormatError
        If batch.json was not written by a batch, or has another schema.
    """
    path = folder / SETTINGS_FILE
    if not path.exists():
        return None
    data = read_json(path)
    no_batch = FormatError(f"{path} was not written by a batch of this program. Choose another folder.")
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise no_batch
    check_schema(data, SCHEMA, f"batch {path}")
    batch = Section("batch", data)
    try:
        return batch.get("settings", dict[str, Any]), batch.get("levels", Levels)
    except FormatError:
        raise no_batch from None


def write_settings(folder: Path, facts: Mapping[str, Any], levels: Levels) -> None:
    """Write facts and colour range to the folder of the results."""
    write_bytes(folder / SETTINGS_FILE, json_file(SCHEMA, {"settings": facts, "levels": levels}))


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """List the differences between the facts of two settings: "parameters.smoothness: 3.0, now 1.0"."""
    old, new = dict(_flat(before)), dict(_flat(now))
    return [
        f"{name}: {old.get(name)}, now {new.get(name)}" for name in {**old, **new} if old.get(name) != new.get(name)
    ]


_MAX_LISTED = 3


def some(things: Sequence[str]) -> str:
    """Return the first few of several texts, and the number of the others."""
    more = len(things) - _MAX_LISTED
    return "; ".join(things[:_MAX_LISTED]) + (f"; and {more} more" if more > 0 else "")


def _flat(facts: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in facts.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _content_sha256(path: str) -> str:
    """Return the SHA-256 of a file, or of the files in a folder and their names."""
    if not os.path.isdir(path):
        return file_sha256(path)
    with told_as(InputError, f"{path}: cannot be read ({{error}}). Check its permissions.", OSError):
        files = sorted(entry.name for entry in os.scandir(path) if entry.is_file())
    lines = [f"{name} {file_sha256(os.path.join(path, name))}" for name in files]
    return hashlib.sha256("\n".join(lines).encode(errors="backslashreplace")).hexdigest()

"""The library's half of the table: SHA-256 of blocks, depth, expected error, curves and files."""

import dataclasses
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import ilf

from . import commands
from .frames import FRAMES
from .hashes import Hashes, of_array, of_files, of_text
from .settings import COMPLETIONS, EXTRACTIONS

CURVES = "i", "stage", "sigma_i", "l1", "residual", "held_out", "error"
"""Values of every iteration; its seconds differ from run to run."""

frame_of = cache(lambda name: FRAMES[name]())
blocks_of = cache(lambda name: ilf.extract_blocks(frame_of(name)))


def functions(frame: str) -> Hashes:
    """What functions of the library give that no completion shows."""
    source, blocks = frame_of(frame), blocks_of(frame)
    stepper = ilf.iterate(source, blocks, 2)
    records = list(stepper)
    inside, outside = [(30, 20)], [(5, 50)]
    return {
        "edge strength": of_array(ilf.edge_strength(source)),
        "selected": of_array(ilf.select_region(source, inside=inside, outside=outside)),
        "surface": of_array(stepper.surface),
        "curve": of_array(_curves(records)),
        "normals": of_array(ilf.surface_normals(source.depth, source.intrinsics)),
        "extrapolated": of_array(ilf.extrapolate(ilf.complete(source, blocks == 1, max_iterations=20)).depth),
    }


def completion(frame: str, setting: dict[str, Any]) -> Hashes:
    """All hashes of one setting of `COMPLETIONS` on a frame."""
    given = dict(setting)
    change, files, only = given.pop("frame", None), given.pop("files", {"mesh": "glb"}), given.pop("only", None)
    blocks, source = given.pop("blocks", blocks_of(frame)), frame_of(frame)
    source = change(source) if change else source
    given = {name: value(source, blocks) if callable(value) else value for name, value in given.items() if name != "on"}
    result = dataclasses.replace(ilf.Run.of(source, blocks, **given), only=only).complete()
    found = {
        "blocks": of_array(result.blocks),
        "depth": of_array(result.depth),
        "extrapolated": of_array(result.extrapolated),
        "expected error": of_array(ilf.expected_error(result)),
        "curves": of_array(_curves(record for history in result.history.values() for record in history)),
        "notes": of_text("\n".join(result.notes)),
    }
    with TemporaryDirectory() as folder:
        result.save(folder, **files)
        return found | of_files(Path(folder))


def _curves(records: Iterable[Any]) -> np.ndarray:
    return np.array([[getattr(record, name) for name in CURVES] for record in records], float)


def make() -> dict[str, Hashes]:
    """The hashes of all settings on all frames, and of the commands."""
    table = {}
    for frame in FRAMES:
        table[f"{frame}: functions"] = functions(frame)
        for name, setting in EXTRACTIONS.items():
            table[f"{frame}: blocks, {name}"] = {"blocks": of_array(ilf.extract_blocks(frame_of(frame), **setting))}
        for name, setting in COMPLETIONS.items():
            if setting.get("on", frame) == frame:
                table[f"{frame}: {name}"] = completion(frame, setting)
    return table | commands.make()

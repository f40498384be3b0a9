"""A reference to a frame: where its files are and how they are read, and whether this program has completed it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import NoneType
from typing import Any, Self

from .._runtime.files import absolute, is_address, read_json, split_dataset, with_dataset
from .._runtime.folders import folder_at
from .._runtime.schema import Section
from ..data.frame import FrameInputs
from ..errors import InputError
from .named_places import NotAllowed, named_in
from .naming import name_from_path, recorded_frame_name
from .reading_options import AS_STATED, ReadingOptions

RECORD_FILE = "run.json"
"""File of the record of a run, beside its results."""

SHARDS_FILE = "shards.json"
"""File of a folder of shards that states what they contain."""

COMPLETED_DEPTH = (
    "the depth was completed by ILF Studio, so that filled depth counts as measured. Give the frame that was completed."
)


@dataclass(frozen=True)
class FrameRef:
    """Reference to a frame: a folder with meta.json, a colour file with its depth file, or a frame of a recording.
    `ilf.sources.reading.read_frame` reads it.

    `frame` is the key of a frame in a recording; `rgb` is then the recording, and `depth` is None. `stated_in` is the
    opened folder, or the address, of the file that states these paths, "" if it is not known, or None for paths of the
    user. What a file states is read only where `named_in` allows it. A dataset that is named behind the depth file, as
    FILE.h5:/depth, becomes the option.
    """

    rgb: str
    depth: str | None = None
    frame: str | None = None
    options: ReadingOptions = AS_STATED
    stated_in: str | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        depth, dataset = (None, None) if self.depth is None else split_dataset(self.depth)
        if dataset is not None:
            object.__setattr__(self, "depth", depth)
            object.__setattr__(self, "options", replace(self.options, dataset=dataset))

    @classmethod
    def of(cls, inputs: FrameInputs) -> Self:
        """The reference to a frame with these inputs, without its guide and its invalid mask."""
        return cls.from_json(Section("frame", {"frame": None, **inputs.arguments}))

    @classmethod
    def from_json(cls, data: Section, stated_in: str | None = None) -> Self:
        """The reference in an object of a JSON file; raises FormatError for missing or wrong values."""
        depth, frame = (data.get(key, str, NoneType) for key in ("depth", "frame"))
        return cls(data.get("rgb", str), depth, frame, ReadingOptions.from_json(data), stated_in)

    def to_json(self) -> dict[str, Any]:
        """The reference as an object for JSON: the location and the given options."""
        return {"rgb": self.rgb, "depth": self.depth, "frame": self.frame, **self.options.to_json()}

    @property
    def key(self) -> str:
        """Unique key: the path of the file or folder with the depth, followed by the dataset, or by the frame's key in
        a recording."""
        path = with_dataset(absolute(self.depth or self.rgb), self.options.dataset)
        return path if self.frame is None else f"{path}#{self.frame}"

    @property
    def name(self) -> str:
        """Name of the frame before it has been read."""
        path = Path(absolute(self.rgb))
        if self.frame is not None:
            return recorded_frame_name(path, self.frame)
        return path.name if self.depth is None else name_from_path(path)

    @property
    def paths(self) -> tuple[str, ...]:
        """All given paths: of the colour file, folder or recording, the depth file and the files of the options."""
        return self.rgb, *(() if self.depth is None else (self.depth,)), *self.options.paths.values()

    def with_paths(self, change: Callable[[str], str], *, cameras: bool = False) -> Self:
        """A copy with changed paths; with `cameras`, also those of files with intrinsics."""
        rgb, depth = change(self.rgb), None if self.depth is None else change(self.depth)
        return replace(self, rgb=rgb, depth=depth, options=self.options.with_paths(change, cameras=cameras))

    def with_options(self, **changes: Any) -> Self:
        """A copy with changed reading options."""
        return replace(self, options=replace(self.options, **changes))

    def absolute(self) -> Self:
        """A copy with absolute paths; itself if all paths are absolute."""
        return self if all(map(os.path.isabs, self.paths)) else self.with_paths(absolute)

    def allowed(self) -> Self:
        """The reference with paths that may be opened; raises as `named_in`."""
        if self.stated_in is None:
            return self
        base, refused = self.stated_in, list[str]()

        def checked(path: str) -> str:
            try:
                return named_in(path, base)
            except NotAllowed as error:
                refused.extend(error.places)
                return path

        found = replace(self.with_paths(checked, cameras=True), stated_in=None)
        if refused:
            raise NotAllowed(*refused)
        return found


# Results of this program, whose depth was completed, beside measured frames.


def is_shards(path: str | os.PathLike[str]) -> bool:
    """Whether a folder or an address contains shards, finished or not."""
    return folder_at(path).exists(SHARDS_FILE)


def is_result_folder(ref: FrameRef) -> bool:
    """Whether a frame is a folder with the result and the record of a run."""
    return ref.depth is None and ref.frame is None and is_result(ref)


def is_result(ref: FrameRef) -> bool:
    """Whether the depth of a frame was completed by this program, so that not all of it was measured. False at
    addresses."""
    if ref.frame is not None:
        return not is_address(ref.rgb) and is_shards(ref.rgb)
    record = os.path.join(ref.rgb if ref.depth is None else os.path.dirname(ref.depth), RECORD_FILE)
    if is_address(record) or not os.path.isfile(record):
        return False
    if ref.depth is None:
        return True
    try:
        data = read_json(record)
    except InputError:
        return False
    outputs = data.get("outputs") if isinstance(data, dict) else None
    return isinstance(outputs, dict) and os.path.basename(ref.depth) in outputs

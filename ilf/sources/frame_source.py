"""Location of a frame and the options for reading it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from .._runtime.addresses import absolute, is_address
from .._runtime.named_places import NotAllowed, named_in
from .._runtime.schema import Section
from ..data.camera import Camera
from ..errors import InputError, warn_of_reading
from .naming import name_from_path, recorded_frame_name
from .own_results import is_result
from .reading_options import AS_STATED, OPTIONS, ReadingOptions

if TYPE_CHECKING:
    from ..data.frame import FrameInputs, RGBDFrame
    from ..io.depth_reading import DepthReading
    from .frames import FrameFiles
    from .recorded import ReadFrame
    from .registration import RawPair


@dataclass(frozen=True)
class FrameSource:
    """Location of a frame: a folder with meta.json, a colour file with its depth file, or a frame of a recording.

    `frame` is the key of a frame in a recording; `rgb` is then the recording, and `depth` is None. `stated_in` is the
    opened folder, or the address, of the file that states these paths, "" if it is not known, or None for paths of the
    user. What a file states is read only where `named_in` allows it.
    """

    rgb: str
    depth: str | None = None
    frame: str | None = None
    options: ReadingOptions = AS_STATED
    stated_in: str | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(cls, inputs: FrameInputs) -> Self:
        """The source of a frame with these inputs, without its guide and its invalid mask."""
        ground_truth = inputs.ground_truth
        options = ReadingOptions(
            encoding=inputs.encoding,
            depth_units=inputs.depth_units if inputs.encoding is None else None,
            invalid=inputs.invalid,
            intrinsics=inputs.intrinsics,
            depth_intrinsics=inputs.depth_intrinsics,
            ground_truth=None if ground_truth is None else ground_truth.path,
            ground_truth_units=None if ground_truth is None else ground_truth.units,
        )
        return cls(inputs.rgb.path, inputs.depth.path if inputs.frame is None else None, inputs.frame, options)

    @classmethod
    def from_json(cls, data: Section, stated_in: str | None = None) -> Self:
        """The source in an object of a JSON file; raises FormatError for missing or wrong values."""
        depth, frame = (data.get(key, str, NoneType) for key in ("depth", "frame"))
        return cls(data.get("rgb", str), depth, frame, ReadingOptions.from_json(data), stated_in)

    def to_json(self) -> dict[str, Any]:
        """The source as an object for JSON: the location and the given options."""
        return {"rgb": self.rgb, "depth": self.depth, "frame": self.frame, **self.options.to_json()}

    @property
    def key(self) -> str:
        """Unique key: the path of the file or folder with the depth, followed by the frame's key in a recording."""
        path = absolute(self.depth or self.rgb)
        return path if self.frame is None else f"{path}#{self.frame}"

    @property
    def name(self) -> str:
        """Name of the frame before it has been read."""
        path = Path(absolute(self.rgb))
        if self.frame is not None:
            return recorded_frame_name(path, self.frame)
        return path.name if self.depth is None else name_from_path(path)

    @property
    def is_result(self) -> bool:
        """Whether its depth was completed by this program, so that not all of it was measured. False at addresses."""
        return is_result(self.rgb, self.depth, self.frame)

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
        """The source of paths that may be opened; raises as `named_in`."""
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

    def load(self, warn: bool = False) -> RGBDFrame:
        """Read the frame; raises what `ilf.load_frame` and `allowed` do. Plausibility warnings are in its `notes`; they
        are issued as `DepthWarning` only with `warn`."""
        from .frames import load_frame

        own = self.allowed()
        return load_frame(own.rgb, own.depth, frame=own.frame, warn=warn, **vars(own.options))

    def load_pair(self, warn: bool = False) -> RawPair:
        """Read colour and depth as captured by their two cameras, before registration; for registered images both
        cameras are the same. Plausibility warnings are as in `load`.

        Raises
        ------
        InputError
            If a camera is not known, and as `ilf.load_frame`.
        """
        from .registration import RawPair

        if self.frame is not None:
            recorded = self.recorded()
            for text in recorded.reading.warnings if warn else ():
                warn_of_reading(text)
            return recorded.pair()
        frame = self.load(warn)
        if frame.inputs is not None and frame.inputs.depth_intrinsics is not None:
            from ..io.images import read_colour
            from .frames import pair_of_images

            inputs = frame.inputs
            with self.copied() as here:
                colour, metres = read_colour(here.files().rgb), here.read_depth().metres
            given = None if inputs.intrinsics is None else Camera(*inputs.intrinsics)
            pair = pair_of_images(colour, metres, given, inputs, frame.name)
            return replace(pair, notes=frame.notes)
        if frame.intrinsics is None:
            raise InputError(f"{self.rgb}: the camera's intrinsics are not known. Give them to read the raw pair.")
        camera = frame.intrinsics
        return RawPair(frame.rgb, frame.measured, camera, camera, np.eye(4), frame.name, frame.inputs, frame.notes)

    def read_depth(self) -> DepthReading:
        """Read the depth alone, with its plausibility warnings; its scale is not checked."""
        from .frames import read_frame_depth

        if self.frame is not None:
            return self.recorded().reading
        with self.copied() as here:
            return read_frame_depth(here.rgb, here.depth, here.options)

    def recorded(self) -> ReadFrame:
        """Read a frame of a recording as stored, and its depth in metres; raises what `ilf.load_frame` does."""
        from .recorded import read_recorded

        own = self.allowed()
        return read_recorded(own.rgb, own.frame or "", own.options.depth_encoding, own.options.invalid)

    def files(self) -> FrameFiles:
        """The frame's files with the options given here or in a meta.json beside them; raises what `frame_folder`
        does."""
        from .frames import files_of

        own = self.allowed()
        found = files_of(own.rgb, own.depth, beside=True)
        return replace(found, options=own.options.or_else(found.options))

    @contextmanager
    def copied(self) -> Iterator[Self]:
        """Provide the frame of files on this machine: itself, or copies of the files at addresses. Within the block,
        errors name the addresses; raises InputError as `copied_frame`."""
        own = self.allowed()
        if own.frame is not None or not any(map(is_address, own.paths)):
            yield own
            return
        from .remote import copied_frame

        with copied_frame(own.rgb, own.depth, own.options) as (rgb, depth, options):
            yield replace(own, rgb=rgb, depth=depth, options=options)

    def beside(self) -> str:
        """A sentence that lists what is read from a meta.json beside the two files; "" for nothing."""
        from .frames import META_NAME, meta_beside

        own = self.allowed()
        files = meta_beside(own.rgb, own.depth) if own.depth is not None else None
        if files is None:
            return ""
        added = self.options.or_else(files.options).given.keys() - self.options.given.keys()
        used_items = ["name", *(option.label for name, option in OPTIONS.items() if name in added and option.label)]
        return f"Read from {META_NAME} beside the files: {', '.join(used_items)}."

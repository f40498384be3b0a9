"""Location of a frame and the options for reading it."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from ..errors import InputError, warn_of_reading
from .naming import name_from_path, recorded_frame_name

if TYPE_CHECKING:
    from ..data.frame import FrameInputs, RGBDFrame
    from ..io.cameras import IntrinsicsSpec
    from ..io.depth_reading import DepthReading
    from ..io.encodings import EncodingSpec
    from .frames import FrameFiles
    from .recorded import ReadFrame
    from .registration import RawPair


@dataclass(frozen=True)
class FrameSource:
    """Location of a frame: a folder with meta.json, a colour file with its depth file, or a frame of a recording.

    `depth_units`, `encoding`, `invalid` and `intrinsics` are as in `ilf.load_frame`. `ground_truth` is the ground
    truth file (None: that of the folder, if any), and `ground_truth_units` are its file units per metre. `guide` is
    the guide file (None: that of the folder, if any). `frame` is the key of a frame in a recording; `rgb` is then the
    recording, and `depth` is None. `confidence` is the confidence map (None: that of the folder, if any); depth below
    `min_confidence` counts as missing.
    """

    rgb: str
    depth: str | None = None
    depth_units: float | None = None
    intrinsics: IntrinsicsSpec | None = None
    ground_truth: str | None = None
    ground_truth_units: float | None = None
    guide: str | None = None
    encoding: EncodingSpec | None = None
    invalid: float | None = None
    frame: str | None = None
    confidence: str | None = None
    min_confidence: float | None = None

    @classmethod
    def of(cls, inputs: FrameInputs) -> Self:
        """The source of a frame with these inputs, without its guide and its invalid mask."""
        ground_truth = inputs.ground_truth
        return cls(
            inputs.rgb.path,
            inputs.depth.path if inputs.frame is None else None,
            inputs.depth_units if inputs.encoding is None else None,
            inputs.intrinsics,
            None if ground_truth is None else ground_truth.path,
            None if ground_truth is None else ground_truth.units,
            encoding=inputs.encoding,
            invalid=inputs.invalid,
            frame=inputs.frame,
        )

    @property
    def key(self) -> str:
        """Unique key: the path of the file or folder with the depth, followed by the frame's key in a recording."""
        path = os.path.abspath(self.depth or self.rgb)
        return path if self.frame is None else f"{path}#{self.frame}"

    @property
    def name(self) -> str:
        """Name of the frame before it has been read."""
        path = Path(self.rgb).absolute()
        if self.frame is not None:
            return recorded_frame_name(path, self.frame)
        return path.name if self.depth is None else name_from_path(path)

    def absolute(self) -> FrameSource:
        """A copy with absolute paths; itself if all paths are absolute."""
        paths = {name: getattr(self, name) for name in ("rgb", "depth", "ground_truth", "guide", "confidence")}
        if all(path is None or os.path.isabs(path) for path in paths.values()):
            return self
        return replace(self, **{name: os.path.abspath(path) for name, path in paths.items() if path is not None})

    def load(self, warn: bool = False) -> RGBDFrame:
        """Read the frame; raises what `ilf.load_frame` does. Plausibility warnings are in its `notes`; they are issued
        as `DepthWarning` only with `warn`."""
        from .frames import load_frame

        return load_frame(
            self.rgb,
            self.depth,
            depth_units=self.depth_units,
            encoding=self.encoding,
            invalid=self.invalid,
            intrinsics=self.intrinsics,
            ground_truth=self.ground_truth,
            ground_truth_units=self.ground_truth_units,
            guide=self.guide,
            frame=self.frame,
            confidence=self.confidence,
            min_confidence=self.min_confidence,
            warn=warn,
        )

    def load_pair(self, warn: bool = False) -> RawPair:
        """Read colour and depth as captured by their two cameras, before registration; for registered images both
        cameras are the same. Plausibility warnings are as in `load`.

        Raises
        ------
        InputError
            If a camera is not known, and as `ilf.load_frame`.
        """
        from .registration import Camera, RawPair

        if self.frame is not None:
            recorded = self.recorded()
            for text in recorded.reading.warnings if warn else ():
                warn_of_reading(text)
            return recorded.pair()
        frame = self.load(warn)
        if frame.intrinsics is None:
            raise InputError(f"{self.rgb}: the camera's intrinsics are not known. Give them to read the raw pair.")
        camera = Camera(frame.intrinsics, (frame.shape[1], frame.shape[0]))
        return RawPair(frame.rgb, frame.measured, camera, camera, np.eye(4), frame.name, frame.inputs, frame.notes)

    def read_depth(self) -> DepthReading:
        """Read the depth alone, with its plausibility warnings; its scale is not checked."""
        from .frames import read_frame_depth

        if self.frame is not None:
            return self.recorded().reading
        return read_frame_depth(self.rgb, self.depth, self._encoding(), self.invalid)

    def recorded(self) -> ReadFrame:
        """Read a frame of a recording as stored, and its depth in metres; raises what `ilf.load_frame` does."""
        from .recorded import read_recorded

        return read_recorded(self.rgb, self.frame or "", self._encoding(), self.invalid)

    def _encoding(self) -> EncodingSpec | None:
        from ..io.encodings import single_encoding

        return single_encoding(self.encoding, self.depth_units)

    def files(self) -> FrameFiles:
        """The frame's files with the options given here or in a meta.json beside them; raises what `frame_folder`
        does."""
        from ..io.cameras import intrinsics_from
        from .frames import files_of

        found = files_of(self.rgb, self.depth, beside=True)
        spec = self._encoding()
        return replace(
            found,
            depth_units=None if spec is not None else found.depth_units,
            encoding=found.encoding if spec is None else spec,
            invalid=found.invalid if self.invalid is None else self.invalid,
            intrinsics=intrinsics_from(self.intrinsics) or found.intrinsics,
            confidence=found.confidence if self.confidence is None else Path(self.confidence),
            min_confidence=found.min_confidence if self.min_confidence is None else self.min_confidence,
        )

    def beside(self) -> str:
        """A sentence that lists what is read from a meta.json beside the two files; "" for nothing."""
        from .frames import META_NAME, meta_beside

        files = meta_beside(self.rgb, self.depth) if self.depth is not None else None
        if files is None:
            return ""
        used_items = ["name"]
        has_no_encoding = self.depth_units is None and self.encoding is None
        used_items += ["depth units"] * (has_no_encoding and files.depth_units is not None)
        used_items += ["depth encoding"] * (has_no_encoding and files.encoding is not None)
        used_items += ["invalid value"] * (self.invalid is None and files.invalid is not None)
        used_items += ["intrinsics"] * (self.intrinsics is None and files.intrinsics is not None)
        used_items += ["ground truth"] * (self.ground_truth is None and files.ground_truth is not None)
        used_items += ["guide"] * (self.guide is None and files.guide is not None)
        used_items += ["min. confidence"] * (self.min_confidence is None and files.min_confidence is not None)
        return f"Read from {META_NAME} beside the files: {', '.join(used_items)}."

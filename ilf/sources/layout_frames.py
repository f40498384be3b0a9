"""The frames of a folder with a layout: files that belong together, and how each frame is read."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import islice
from pathlib import Path
from typing import cast

from .._runtime.formatting import natural
from ..data.camera import is_preset
from ..errors import InputError
from ..io.camera_files import ENTRY_MARK, read_camera_file
from ..io.cameras import IntrinsicsSpec, is_numbers, sized_camera
from ..io.encodings import ray_encoding
from .file_patterns import File, Folders, alternatives, files_like, filled, placeholders
from .frame_ref import AS_STATED, FrameRef, ReadingOptions
from .layout import GIVEN, LIST_SUFFIX, Layout
from .named_places import named_in
from .trajectories import as_camera_to_world, image_name, read_trajectory

_BOP_SCALE = 0.01, 20.0
"""Range of the depth_scale [mm] of BOP's data sets."""

_LEVELS_ABOVE = 3
"""Number of folders above the opened one in which a layout's other files are looked for."""


_OPTIONS = {
    "truth": "ground_truth",
    "confidence": "confidence",
    "K": "intrinsics",
    "depth_K": "depth_intrinsics",
    "pose": "pose",
}
"""Key of a layout's further files -> the reading option that they give."""

_Frame = tuple[str, str, dict[str, str]]
"""Paths of colour and depth relative to the opened folder, and the text of each placeholder."""


class LayoutFrames:
    """Listing of the frames of a folder by a layout.

    Parameters
    ----------
    layout : Layout
    folders : Folders
        The opened folder.
    """

    def __init__(self, layout: Layout, folders: Folders) -> None:
        self._layout, self._folders = layout, folders
        self._camera_file, self._shared = cache(read_camera_file), cache(self._found_above)
        self._trajectory = cache(read_trajectory)
        is_plain = (layout.pose_maps, layout.pose_axes) == ("camera-to-world", "y-down")
        self._are_poses_files = is_plain and any(_names(layout.pose))
        """Whether each frame has a file of its pose that can be read as it is."""
        files = self._files(layout.rgb), self._files(layout.depth, is_depth=True)
        self.counts = tuple(map(len, files))
        """Numbers of files that match the patterns of colour and depth."""
        self.unmatched = 0, 0
        """Numbers of colour and depth files without the other."""
        self.frames = self._matched(*files) if all(files) else []
        """Colour and depth files that belong together."""
        self.not_found: tuple[str, ...] = ()
        """Keys of the layout of whose files none was found, after `sources`."""

    def sources(self, given: ReadingOptions = AS_STATED) -> list[FrameRef]:
        """The frames, in natural order of their colour files; empty if there are none.

        Raises
        ------
        InputError
            If a file of intrinsics is missing.
        FormatError
            If a file of intrinsics or poses is damaged.
        """
        root, patterns = self._folders.root, (self._layout.rgb, self._layout.depth)
        stated_in = root if any(one.endswith(LIST_SUFFIX) for text in patterns for one in alternatives(text)) else None
        sources = [
            FrameRef(
                os.path.join(root, rgb),
                os.path.join(root, depth),
                options=given.or_else(self._options((rgb, depth, texts), pose, given)),
                stated_in=stated_in,
            )
            for (rgb, depth, texts), pose in zip(self.frames, self._poses(), strict=True)
        ]
        self.not_found = tuple(
            f"{key}={text}"
            for key, option in _OPTIONS.items()
            if (text := getattr(self._layout, key)) and not any(getattr(one.options, option) for one in sources)
        )
        return sources

    def _matched(self, colours: list[File], depths: list[File]) -> list[_Frame]:
        """Colour and depth files whose shared placeholders have the same text."""
        shared = colours[0][1].keys() & depths[0][1].keys()
        of_colour, of_depth = dict[tuple[str, ...], File](), dict[tuple[str, ...], File]()
        for by_key, files in ((of_colour, colours), (of_depth, depths)):
            for path, texts in files:
                by_key.setdefault(tuple(texts[name] for name in shared), (path, texts))
        both = [(*of_colour[key], *of_depth[key]) for key in of_colour if key in of_depth]
        self.unmatched = len(of_colour) - len(both), len(of_depth) - len(both)
        return sorted(
            ((rgb, depth, others | texts) for rgb, texts, depth, others in both), key=lambda one: natural(one[0])
        )

    def _files(self, text: str, is_depth: bool = False) -> list[File]:
        """The files that match a pattern, or that the file it names lists, each once."""
        found: dict[str, dict[str, str]] = {}
        for one in alternatives(text):
            for file in files_like(one, self._folders):
                for path, texts in self._listed(*file, is_depth) if one.endswith(LIST_SUFFIX) else [file]:
                    found.setdefault(path, texts)
        return [*found.items()]

    def _listed(self, path: str, texts: dict[str, str], is_depth: bool) -> Iterator[File]:
        """The images, or their depth files, in a list of images."""
        folder, files = os.path.dirname(path), self._trajectory(Path(self._folders.root, path)).depth_files
        stems = Counter(map(_stem, files))
        for image, depth in files.items():
            if file := depth if is_depth else image:
                name = _stem(image) if stems[_stem(image)] == 1 else image_name(image)
                yield os.path.normpath(os.path.join(folder, file)), texts | {"1": name}

    # What belongs to a frame besides colour and depth.

    def _options(self, frame: _Frame, pose: str | tuple[float, ...] | None, given: ReadingOptions) -> ReadingOptions:
        layout, (_, depth, texts) = self._layout, frame
        camera, depth_camera = (
            self._camera(text, frame) if stated is None else stated
            for text, stated in ((layout.K, given.intrinsics), (layout.depth_K, given.depth_intrinsics))
        )
        is_one = layout.depth_K and layout.depth_K == layout.K  # camera, whose images differ in size
        if is_one and given.depth_intrinsics is None:
            depth_camera = camera
        units, encoding, file = layout.units, layout.encoding, self._beside(layout.pose, texts)
        if (
            file is not None
            and not self._are_poses_files
            and (stated := self._trajectory(Path(file)).depth_units) is not None
        ):
            units = stated
        scale = camera.get("depth_scale") if isinstance(camera, Mapping) and depth.endswith(".png") else None
        if units is None and isinstance(scale, int | float) and scale > 0:
            # BOP states millimetres per unit, librealsense metres per unit, Open3D the reverse
            is_of_bop = encoding == "bop" or _BOP_SCALE[0] <= scale <= _BOP_SCALE[1]
            units, encoding = 1000 / scale if is_of_bop else max(scale, 1 / scale), None
        if layout.distance == "ray":
            if (of_depth := camera if depth_camera is None else depth_camera) is None:
                raise InputError(
                    "Depth along the ray needs the camera's intrinsics, whose file K is missing. Put it there."
                )
            units, encoding = None, ray_encoding(units or 1.0, sized_camera(of_depth))
        truth = self._beside(layout.truth, texts)
        return ReadingOptions(
            encoding=encoding,
            depth_units=units,
            invalid=layout.invalid,
            dataset=layout.dataset,
            min_confidence=layout.min_confidence,
            intrinsics=camera,
            depth_intrinsics=depth_camera,
            ground_truth=truth,
            ground_truth_units=None if truth is None else layout.truth_units,
            confidence=self._beside(layout.confidence, texts),
            pose=pose,
        )

    def _beside(self, text: str, texts: dict[str, str]) -> str | None:
        """The absolute path of another file of the layout, in the folders that {} stands for; one for several frames
        may also lie above. None if there is none."""
        scene = texts.get("", "")
        if any(_names(text)):
            return self._existing(text, os.path.join(self._folders.root, scene), texts)
        return self._shared(text, scene) if text else None

    def _found_above(self, text: str, scene: str) -> str | None:
        """The path of a file for several frames, in the folder of their scene or above."""
        folder = Path(self._folders.root, scene)
        levels = scene.count("/") + bool(scene) + _LEVELS_ABOVE
        places = (self._existing(text, str(place), {}) for place in (folder, *islice(folder.parents, levels)))
        return next((path for path in places if path is not None), None)

    def _existing(self, text: str, folder: str, texts: Mapping[str, str]) -> str | None:
        paths = (os.path.join(folder, filled(one, texts)) for one in alternatives(text))
        if self._layout.name != GIVEN and re.match(r"[\\/]|[A-Za-z]:|(.*/)?\.\.(/|$)", text):
            paths = (named_in(path, self._folders.root) for path in paths)
        return next((path for path in paths if os.path.exists(path)), None)

    def _camera(self, text: str, frame: _Frame) -> IntrinsicsSpec | None:
        """The intrinsics that a layout's text states, or those of the file that it names: of several, the first."""
        rgb, _, texts = frame
        for one in filter(None, text.split("|")):
            if is_preset(one) or is_numbers(one):
                return one
            pattern, _, entry = one.partition(ENTRY_MARK)
            if (path := self._beside(pattern, texts)) is None:
                continue
            if pattern != self._layout.pose:
                return self._camera_file(Path(path), filled(entry, texts) if entry else "")
            if (camera := self._trajectory(Path(path)).camera(rgb)) is not None:
                return cast("IntrinsicsSpec", camera)
        return None

    def _poses(self) -> Iterator[str | tuple[float, ...] | None]:
        """The pose of each frame: the path of its file, if that can be read as it is, or the numbers of its matrix."""
        layout, paths = self._layout, [self._beside(self._layout.pose, texts) for *_, texts in self.frames]
        if self._are_poses_files:
            yield from paths
            return
        counts, places = Counter(paths), Counter[str | None]()
        for (rgb, *_), path in zip(self.frames, paths, strict=True):
            pose = None if path is None else self._trajectory(Path(path)).pose(rgb, places[path], counts[path])
            places[path] += 1
            pose = as_camera_to_world(pose, layout.pose_maps, layout.pose_axes)
            yield None if pose is None else tuple(pose.ravel().tolist())


def _stem(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0]


@cache
def _names(text: str) -> tuple[str, ...]:
    """The placeholders of all alternatives of a pattern."""
    return tuple(name for one in alternatives(text) for name in placeholders(one))

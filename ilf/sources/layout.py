"""A layout: the names of a data set's files and how they are read, as text or as a table of a TOML file."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from .._runtime.files import read_file, split_dataset
from .._runtime.schema import converted
from ..errors import FormatError, ParameterError, told_as
from ..io.encodings import single_encoding
from .file_patterns import alternatives, check_pattern, placeholders

GIVEN = "given"
"""Name of a layout that the user has written as text."""

LIST_SUFFIX = ".json"
"""Extension of a file that lists images, in place of their pattern."""


class Layout(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The files of frames in a folder, and how they are read.

    `rgb` and `depth` are patterns of paths, see `files_like`; two files whose shared placeholders have equal text are
    a frame. In place of a pattern, both may be the path of a transforms.json, which lists images and depth files; what
    they share is then the name of the image, *. The other paths may contain the same placeholders. They are relative
    to the folders that {} stands for. A file for several frames, without other placeholders, is also looked for in the
    folders above, up to three levels above the opened folder.

    Parameters
    ----------
    rgb, depth : str
        Patterns.
    truth, confidence : str
        Ground truth and confidence map.
    K : str
        Intrinsics of colour: a file, see `ilf.io.camera_files.read_camera_file`, with the name of one of several
        cameras in it after #; a preset; or numbers fx,fy,cx,cy, followed by the width and height of the image that they
        apply to if others are scaled. Of several, divided by |, the first that there is.
    depth_K : str
        Intrinsics of depth of another size than colour, in the same forms.
    pose : str
        Camera poses: a file for each frame with a matrix, or one of the files that `ilf.sources.trajectories` reads.
    dataset, units, encoding, invalid, min_confidence, truth_units
        As the options of `ilf.load_frame`.
    distance : str
        "z": depth is measured along the camera's axis; "ray": along the ray of each pixel.
    pose_maps, pose_axes : str
        Poses map points from the camera to the world, or from the world to the camera; the camera's axes are x right, y
        down, z forward ("y-down"), or x right, y up, z backward ("y-up").
    needs : tuple of str
        Further paths or patterns without which a folder is not recognised.
    excludes : tuple of str
        Patterns of files with which it is not recognised.
    registered : bool
        Whether depth has the pixels of colour, or `depth_K` registers it.
    title, note : str
        Name of the data set, and a sentence for the user.
    name : str
        Name of the layout.
    """

    rgb: str
    depth: str
    truth: str = ""
    confidence: str = ""
    K: str = ""
    depth_K: str = ""
    pose: str = ""
    dataset: str | None = None
    units: Annotated[float, msgspec.Meta(gt=0)] | None = None
    encoding: str | None = None
    invalid: float | None = None
    min_confidence: float | None = None
    truth_units: Annotated[float, msgspec.Meta(gt=0)] | None = None
    distance: Literal["z", "ray"] = "z"
    pose_maps: Literal["camera-to-world", "world-to-camera"] = "camera-to-world"
    pose_axes: Literal["y-down", "y-up"] = "y-down"
    needs: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    registered: bool = True
    title: str = ""
    note: str = ""
    name: str = ""

    @property
    def text(self) -> str:
        """Its name and the title of the data set."""
        return f"{self.name} ({self.title})" if self.title else self.name


def layout_of(values: Mapping[str, Any], name: str, where: str) -> Layout:
    """The layout with these values.

    Parameters
    ----------
    values : mapping
        Name of a field of `Layout` -> value; numbers may be text.
    name : str
        Name of the layout.
    where : str
        What contains it, for messages.

    Raises
    ------
    FormatError
        If a value is missing, unknown or not valid.
    """
    with told_as(FormatError, f"{where}: {{error}}", (FormatError, ParameterError)):
        depth, dataset = split_dataset(str(values.get("depth", "")))
        named = {} if dataset is None else {"depth": depth, "dataset": dataset}
        layout = converted({**values, **named, "name": name}, Layout, f"layout {name!r}", strict=False)
        given = single_encoding(layout.encoding, layout.units)
        if layout.distance == "ray" and (isinstance(given, str) or not (layout.K or layout.depth_K)):
            raise ParameterError("distance=ray needs K, and units instead of an encoding.")
        patterns = layout.rgb, layout.depth, layout.truth, layout.confidence, layout.pose
        for text in (*patterns, *layout.needs, *layout.excludes):
            check_pattern(text)
        for text in (layout.K, layout.depth_K):
            check_pattern(text.lstrip("/"))
        known = _checked_images(layout)
        others = layout.truth, layout.confidence, layout.K, layout.depth_K, layout.pose
        for text in (one for other in others for one in alternatives(other)):
            if unknown := [one for one in placeholders(text) if one and one not in known]:
                raise ParameterError(f"{text!r} has {{{unknown[0]}}}, which neither rgb nor depth has.")
    return layout


def _checked_images(layout: Layout) -> set[str]:
    """The placeholders of the patterns of colour and depth; raises ParameterError if the two do not fit."""
    known: list[set[str]] = []
    for text in (layout.rgb, layout.depth):
        first, *others = (
            {*placeholders(one), *(["1"] if one.endswith(LIST_SUFFIX) else [])} for one in alternatives(text)
        )
        if any(other != first for other in others):
            raise ParameterError(f"The alternatives of {text!r} must have the same placeholders.")
        known.append(first)
    if not known[0] & known[1]:
        both = f"rgb={layout.rgb} and depth={layout.depth}"
        raise ParameterError(f"{both} have no placeholder in common: write * or {{name}} for what both names have.")
    return known[0] | known[1]


def layout_from_text(text: str) -> Layout:
    """The layout of a text such as "rgb=image/*.png depth=depth/*.png units=1000"; raises FormatError.

    Examples
    --------
    >>> layout_from_text("rgb={}/image/*.png depth={}/sparse_depth/*.png units=256 K=K.txt").units
    256.0
    """
    values: dict[str, Any] = {}
    where = f"--layout {text!r:.200}"
    with told_as(FormatError, f"{where} cannot be read ({{error}}). Close the quotation marks.", ValueError):
        words = shlex.split(text)
    for word in words:
        key, mark, value = word.partition("=")
        if not mark or key in values or key == "name":
            raise FormatError(f"{where}: {word!r:.60} is not key=value, or it is given twice.")
        values[key] = tuple(value.split()) if key in {"needs", "excludes"} else value
    return layout_of(values, GIVEN, where)


_MAX_TOML = 2**16
"""Maximum size of a table of layouts [bytes]; the time to parse names grows with its square."""


def layouts_from_file(path: Path) -> list[Layout]:
    """The layouts of a TOML file: a table for each, or one without a table, named as the file.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it is not TOML, contains no layout, or one that is not valid.
    """
    content = read_file(path)
    if len(content.data) > _MAX_TOML:
        raise FormatError(f"{content} has more than {_MAX_TOML >> 10} KiB: it is no table of layouts.")
    with told_as(FormatError, f"{content} is not valid TOML ({{error}}). Correct it.", (ValueError, RecursionError)):
        data = tomllib.loads(content.data.tobytes().decode("utf-8"))
    if "rgb" in data:
        data = {content.path.stem: data}
    wrong = [name for name, table in data.items() if not isinstance(table, dict) or name == GIVEN]
    if wrong or not data:
        raise FormatError(f"{content} must contain a table [NAME] for each layout, not named {GIVEN}.")
    return [layout_of(table, name, str(content)) for name, table in data.items()]

"""Files with intrinsics, as many programs write them: text to a tree of keys, the cameras in it, and the choice."""

from __future__ import annotations

import configparser
import json
import math
import re
import struct
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml

from .._runtime.files import FileContent, read_file
from ..data.camera import camera_from_numbers, camera_of, lens_problem
from ..errors import FormatError, InputError, told_as
from .camera_places import link_of, places_of, socket_name
from .float_images import read_npy, table_of_names

ENTRY_MARK = "#"
"""Separates the path of a file from the name of one of its cameras."""

CAMERA_FILES = ".json", ".yaml", ".yml", ".txt", ".npy", ".xml", ".ini", ".conf", ".pincam", ".csv", ".bin"
"""Extensions of files of cameras."""


def read_camera_file(path: Path, entry: str = "") -> dict[str, Any]:
    """Read the intrinsics of a camera, as `camera_of` takes them, with what the file states about its lens.

    Parameters
    ----------
    path : Path
        JSON, YAML, XML (all three also as OpenCV's FileStorage), or "name = value" in sections, with the keys of
        Open3D, nerfstudio, librealsense, DepthAI, ROS, OpenCV, Kalibr, ORB-SLAM, KITTI and similar programs; COLMAP's
        cameras.txt or cameras.bin; what rs-enumerate-devices -c prints; text with numbers alone, see `_of_numbers`; a
        snapshot's table of the RealSense Viewer; or NPY with a camera matrix.
    entry : str
        The name of one of several cameras: a key above its numbers, or all of these, separated by /. Case and
        punctuation do not count.

    Raises
    ------
    InputError
        If the file does not exist, or has several cameras and none is named.
    FormatError
        If it is damaged, or contains no camera, or none of that name.
    """
    content = read_file(path)
    camera = chosen_camera(_tree_of(content), str(content), entry)
    with told_as(FormatError, f"{content}: {{error}}", InputError):
        if "angle_x" not in camera and not lens_problem(camera):
            camera_of(camera, None)
    rig = {"rig": f"{content.sha256} {camera['rig']}"} if "rig" in camera else {}
    return camera | {"name": path.name} | rig


def chosen_camera(tree: Any, where: str, entry: str = "") -> dict[str, Any]:
    """The only camera in a tree of mappings and lists, or the named one; raises as `read_camera_file`."""
    cameras = {_NO_NAME.sub("_", key): camera for key, camera in cameras_in(tree)}
    links = {key: link for key, camera in cameras.items() if (link := camera.pop("link", None))}
    if entry and isinstance(tree, Mapping) and len(numbers := _numbers(tree.get(entry)) or []) == 4:
        return {"K": numbers}
    if not cameras:
        raise FormatError(f"{where} contains no camera: neither fx, fy, cx and cy nor a camera matrix (K).")
    wanted = _plain(entry)
    named = {key: camera for key, camera in cameras.items() if entry and _plain(key) == wanted}
    below = {key: camera for key, camera in cameras.items() if not entry or wanted in map(_plain, key.split("/"))}
    found = named or below
    names = " or ".join([*(found or cameras)][:_MAX_NAMES])
    if not found:
        raise FormatError(f"{where} has no camera {entry!r:.40}. It has {names}.")
    (name, first), *others = found.items()
    if any(other != first for _, other in others):
        example = f"{where}{ENTRY_MARK}{name}"
        raise InputError(f"{where} has {len(found)} cameras: {names}? Give the one of this image by name: {example}.")
    return first | places_of(name, links, tree)


# A tree of keys -> the cameras in it.

_ALIASES = {
    "fx": "fx flx focallengthx fu mu", "fy": "fy fly focallengthy fv mv",
    "cx": "cx ppx principalpointx cu u0", "cy": "cy ppy principalpointy cv v0",
    "width": "width w imagewidth xres resolutionx", "height": "height h imageheight yres resolutiony",
    "K": "k cameramatrix intrinsics intrinsicmatrix camk",
    "lens": "lens cameramodel cammodel cameratype distortionmodel distortiontype model modeltype type projection",
    "distortion": "coeffs d", "angle_x": "cameraanglex anglex", "angle_y": "cameraangley angley",
    "size": "size imagesize resolution imageresolution renderproductresolution",
    "focal": "focallength", "principal": "principalpoint", "depth_scale": "depthscale",
}  # fmt: skip
"""Name -> the names that files have for it, in lower case and without punctuation."""
_NAMES = {alias: name for name, aliases in _ALIASES.items() for alias in aliases.split()}
_PAIRS = {"size": ("width", "height"), "focal": ("fx", "fy"), "principal": ("cx", "cy")}
_LISTS = "K", "distortion"
_COEFFICIENTS = "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"
_DISTORTION = re.compile("distort|distc|^dist$")
"""What other names of coefficients of distortion contain, and those of mappings with them."""
_MAX_NAMES = 60
"""Names of cameras in a message."""
_NO_NAME = re.compile(r"[^\w./-]+")
"""What a name that is given on the command line does not have."""
_LENSES_BY_NUMBER = {
    "model3": "ftheta", "model5": "kannala_brandt4", "cameratype1": "fisheye", "cameratype2": "equirectangular",
    "cameratype3": "radial division",
}  # fmt: skip
"""Lens models that are no pinhole, by the numbers that librealsense and DepthAI write."""
_SHARED = {"camera", "image", "resolution", "size", "imagesize", "imageresolution", "metadata", ""}
"""Keys, in the same form, whose content belongs to the camera beside them; "" is that of YAML's <<."""
_ABOUT_IMAGE = "width", "height", "lens", "distortion", "depth_scale"
_DERIVED = re.compile(r"^p\d*$|proj|rect|^new|^opt|^perframe")
"""Keys, in the same form, of camera matrices of the rectified image or of every frame, beside that of the image."""
_MAX_DEPTH = 20


def cameras_in(
    tree: Any, known: Mapping[str, Any] | None = None, path: tuple[str, ...] = ()
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Find the cameras in a tree of mappings and lists: their keys, separated by /, and what is stated about them.

    The numbers of a camera are from one mapping; image size and lens may be stated above, for all cameras below.
    """
    tree = _numbered(tree) if isinstance(tree, list) else tree
    if not isinstance(tree, Mapping) or len(path) > _MAX_DEPTH:
        return
    tree = _nested(tree)
    facts, own = _facts(tree), dict[str, Any]()
    below = {key: item for key, item in tree.items() if isinstance(item, Mapping | list) and _numbers(item) is None}
    for key, item in below.items():
        own = _about_image(own, _shared(_plain(key), item))
    own = _about_image(own, facts)
    around, count = _about_image(known or {}, own), 0
    if numbers := _numbers_in(facts):
        link = link_of(tree, _NO_NAME.sub("_", "/".join(path)))
        yield "/".join(path) or "top", around | numbers | ({"link": link} if link else {})
    has_own = bool(numbers) or any(_is_damaged_matrix(key, item) for key, item in tree.items())
    for key, item in tree.items():
        plain, matrix = _plain(key), _numbers(item) or []
        if _is_camera_matrix(plain, matrix) and not (has_own and (plain in _NAMES or _DERIVED.search(plain))):
            yield "/".join((*path, key)), around | _lettered(tree, key) | {"K": _square(matrix)}
            count += 1
    for key, item in below.items():
        for found in cameras_in(item, {} if numbers else around, (*path, key)):
            yield found
            count += 1
    is_camera = not (path and (_plain(path[-1]) in _SHARED or _DISTORTION.search(_plain(path[-1]))))
    if not numbers and not count and is_camera and lens_problem(own):  # its numbers are those of its lens model
        yield "/".join(path) or "top", around


def _is_damaged_matrix(key: str, item: Any) -> bool:
    """Whether this states the camera matrix by values that are no numbers, in whose place no other matrix is right."""
    values = item.get("data") if isinstance(item, Mapping) else item
    is_flat = isinstance(values, list) and not any(isinstance(value, Mapping) for value in values)
    return _NAMES.get(_plain(key)) == "K" and is_flat and _numbers(item) is None


def _plain(key: str) -> str:
    return re.sub(r"[\W_]", "", key).lower()


def _numbered(items: list[Any]) -> dict[str, Any]:
    """The mappings and lists of a list by their names, if these tell them apart, or numbered from 1."""
    named = [_with_name(item) for item in items if isinstance(item, Mapping | list)]
    are_names = len({name for name, _ in named if name}) == len(named)
    return {name if are_names else str(number): item for number, (name, item) in enumerate(named, 1)}


def _with_name(item: Mapping[Any, Any] | list[Any]) -> tuple[str, Any]:
    """The name and the content of {"name": ...} or, as in DepthAI's files, [socket, {...}]; the name may be empty."""
    if isinstance(item, Mapping):
        return str(item.get("name") or item.get("camera_name") or ""), item
    match item:
        case [int(socket), Mapping() as camera] if 0 <= socket < 26:
            return socket_name(socket), camera
        case [str(name), content]:
            return name, content
    return "", item


def _nested(tree: Mapping[Any, Any]) -> dict[str, Any]:
    """A mapping with "Camera.fx: 1" as "Camera: {fx: 1}"."""
    found: dict[str, Any] = {}
    for key, item in tree.items():
        first, _, rest = str(key).partition(".")
        if rest and not isinstance(item, Mapping) and isinstance(found.setdefault(first, {}), dict):
            found[first][rest] = item
        else:
            found[str(key)] = item
    return found


def _about_image(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """What both state about an image: the second rather than the first, but the lenses of both."""
    found = {name: value for name, value in {**first, **second}.items() if name in _ABOUT_IMAGE}
    lenses = [facts["lens"] for facts in (first, second) if "lens" in facts]
    return found | ({"lens": " ".join(dict.fromkeys(lenses))} if lenses else {})


def _shared(plain: str, item: Any) -> dict[str, Any]:
    """What a mapping states about the camera beside it."""
    is_distortion = bool(_DISTORTION.search(plain))
    if not isinstance(item, Mapping) or not (is_distortion or plain in _SHARED):
        return {}
    facts = _facts(item)
    if is_distortion:
        values = (value if isinstance(value, Mapping | list) else [value] for value in item.values())
        if any(numbers := [number for value in values for number in _numbers(value) or []]):
            facts.setdefault("distortion", numbers)
    return {} if _numbers_in(facts) else facts


def _facts(tree: Mapping[str, Any]) -> dict[str, Any]:
    """What a mapping itself states about a camera, by the names of `_ALIASES`."""
    found: dict[str, Any] = {}
    for key, item in tree.items():
        plain, numbers, told = _plain(str(key)), _numbers(item) or [], str(item).removesuffix(".0")
        name = _NAMES.get(plain, "distortion" if _DISTORTION.search(plain) else "")
        name = "lens" if plain == "distortion" and isinstance(item, str) else name
        if "fisheye" in plain and told in {"True", "true", "1"}:
            name, told = "lens", "fisheye"
        if name == "size" and isinstance(item, str):
            numbers = [float(number) for number in re.findall(r"\d+", item)]
        if name in _PAIRS and numbers and numbers == numbers[:2] * (len(numbers) // 2):
            found |= zip(_PAIRS[name], numbers, strict=False)
        elif name in _LISTS and len(numbers) > 1:
            found[name] = numbers if any(numbers) else found.get(name, numbers)
        elif plain == "cameratype" and told.isdecimal() and "distortionCoeff" not in tree:
            continue  # of Record3D: which of the phone's cameras
        elif name == "lens" and isinstance(item, str | int | float):
            found[name] = f"{found.get(name, '')} {_LENSES_BY_NUMBER.get(plain + told, told)}".strip()
        elif name and name not in {*_PAIRS, *_LISTS, "lens"} and not isinstance(item, Mapping | list):
            found[name] = item
    coefficients = {name: item for name in _COEFFICIENTS if isinstance(item := tree.get(name), int | float)}
    if {"mu", "mv"} <= tree.keys():  # VINS counts the coefficients of a fisheye from 2
        coefficients = {f"k{int(name[1]) - 1}": item for name, item in coefficients.items() if name[0] == "k"}
    if any(coefficients.values()):
        found.setdefault("distortion", coefficients)
    if {"fl_x", "camera_angle_x"} & tree.keys():  # measured from the corner of the top left pixel
        found |= {name: found[name] - 0.5 for name in ("cx", "cy") if isinstance(found.get(name), int | float)}
        found |= {"fy": found["fx"]} if "fx" in found and not {"fy", "angle_y"} & found.keys() else {}
    for name, width in (("cameraFocalLength", "cameraAperture"), ("focal_length", "sensor_width")):
        is_opengl = found.get("K", [0.0])[-1] < 0  # of Kubric, in shares of the image
        if {name, width} <= tree.keys() and (is_opengl or name == "cameraFocalLength"):  # and Isaac Sim: square pixels
            aperture, focal = (_numbers([tree[width]]) or [0.0])[0], tree[name]
            found["angle_x"] = 2 * math.atan2(aperture, 2 * focal) if isinstance(focal, int | float) else 0.0
            found.pop("K", None)
    return found


def _numbers_in(facts: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a camera among facts; empty if there are not all."""
    if any(facts.get("K", ())):  # ROS writes zeros for a camera that is not calibrated
        return {"K": _square(facts["K"])}
    names = "fx", "fy", "cx", "cy", "angle_x", "angle_y"
    is_complete = facts.keys() >= {"fx", "fy", "cx", "cy"} or "angle_x" in facts
    return {name: facts[name] for name in names if name in facts} if is_complete else {}


def _numbers(item: Any) -> list[float] | None:
    """The numbers of a list, a list of rows, or a matrix with its data, in one list; None for anything else."""
    try:
        array = np.asarray(item.get("data") if isinstance(item, Mapping) else item)
    except ValueError:
        return None
    return array.astype(float).ravel().tolist() if array.dtype.kind in "iuf" and array.ndim else None


def _square(numbers: list[float]) -> list[float]:
    """The 3 x 3 matrix in one of 3 or 4 rows and columns, row by row; other numbers as they are."""
    columns = {9: 3, 12: 4, 16: 4}.get(len(numbers))
    return [numbers[columns * row + at] for row in range(3) for at in range(3)] if columns else numbers


def _is_camera_matrix(plain: str, numbers: list[float]) -> bool:
    """Whether numbers are a camera matrix, or four numbers whose key says that they are intrinsics."""
    if len(numbers) not in {9, 12, 16} and not (len(numbers) == 4 and "intrinsic" in plain):
        return False
    try:
        camera = camera_from_numbers(_square(numbers), "")
    except InputError:
        return False
    return min(camera.cx, camera.cy) > 0


def _lettered(tree: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Image size and distortion beside a camera matrix, as in KITTI (K_02, S_02, D_02; P_rect_02, S_rect_02) and OpenCV
    (M1, D1)."""
    size, distortion = _numbers(tree.get(f"S{key[1:]}")) or [], _numbers(tree.get(f"D{key[1:]}"))
    found: dict[str, Any] = dict(zip(("width", "height"), size, strict=False)) if len(size) == 2 else {}
    return found | ({"distortion": distortion} if distortion and key[0] != "P" else {})


# Text -> a tree of keys.

_MAX_TEXT, _MAX_YAML, _MAX_ALIASES = 2**22, 2**18, 20
_COLMAP = re.compile(r"\s*(\d+)\s+([A-Z][A-Z_]+)\s+(\d+)\s+(\d+)((?:\s+[-+.\de]+)+)\s*")
_COLMAP_MODELS = (
    ("SIMPLE_PINHOLE", 3), ("PINHOLE", 4), ("SIMPLE_RADIAL", 4), ("RADIAL", 5), ("OPENCV", 8), ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12), ("FOV", 5), ("SIMPLE_RADIAL_FISHEYE", 4), ("RADIAL_FISHEYE", 5), ("THIN_PRISM_FISHEYE", 12),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16),
)  # fmt: skip
"""Models of cameras.bin, by number, with their counts of parameters."""
_REALSENSE = re.compile(
    r'Intrinsic of "(.+?)"[\s/]+(\d+x\d+)[\s/]+\{?([^}\n]*?)\}?[ \t\r]*((?:\n[ \t]+[^\n:]+:[^\n]*)+)'
)
"""A stream, a size, formats, and lines of intrinsics of rs-enumerate-devices -c."""
_REALSENSE_PLACE = re.compile(
    r'Extrinsic from "Depth"\s+To\s+"Color"\s*:\s*Rotation Matrix:\s*([-+.\de\s]+?)\s*Translation Vector:([-+.\de \t]+)'
)
_ASSIGNED = re.compile(r"^\s*[\w.]+\s*=", re.MULTILINE)


def _tree_of(content: FileContent) -> Any:
    """The content of a file as mappings, lists and numbers; raises FormatError if it is damaged."""
    suffix = content.path.suffix.lower()
    if suffix == ".npy":
        return _of_numbers(content, read_npy(content).ravel().tolist())
    if suffix == ".bin":
        return _of_colmap_binary(content)
    if suffix != ".json" and len(content.data) > _MAX_TEXT:
        raise FormatError(f"{content} has more than {_MAX_TEXT >> 20} MiB. Keep the part with the camera.")
    text = content.data.tobytes().decode("utf-8-sig", "replace")
    try:
        if suffix == ".json" or (text.lstrip()[:1] == "{" and suffix not in {".yaml", ".yml"}):
            data = json.loads(content.data.tobytes(), object_pairs_hook=_once)
            return {"K": data} if isinstance(data, list) and _numbers(data) else data
        if text.lstrip()[:1] == "<":
            return _parsed(_of_xml(text))
        if suffix == ".csv" and "resolution x" in (table := table_of_names(text)):
            return _parsed(table)
        if streams := _REALSENSE.findall(text):
            return _of_realsense(streams, _REALSENSE_PLACE.search(text))
        lines = [line.partition("#")[0] for line in text.splitlines()]
        if cameras := [found.groups() for line in lines if (found := _COLMAP.fullmatch(line))]:
            return _once(
                (number, _of_colmap(model, int(width), int(height), [*map(float, parameters.split())]))
                for number, model, width, height, parameters in cameras
            )
        words = re.split(r"[\s,;\[\]]+", " ".join(lines).strip("[]; \t"))
        if isinstance(numbers := _number_or_text(" ".join(words)), float | list):
            return _of_numbers(content, numbers if isinstance(numbers, list) else [numbers])
        half = len(words) // 2  # a line of names and one of numbers, or lines of a name and a number
        for names, others in ((words[:half], words[half:]), (words[::2], words[1::2])):
            values = _number_or_text(" ".join(others))
            if isinstance(values, list) and len(names) == len(values) and all(map(str.isidentifier, names)):
                return _once(zip(names, values, strict=True))
        return _parsed(_of_sections(text) if _ASSIGNED.search(text) else _of_yaml(text))
    except (yaml.YAMLError, configparser.Error, ElementTree.ParseError, ValueError, RecursionError) as error:
        told = f"{' '.join(str(error).split()):.120}"
        remedy = "Correct it, or give fx,fy,cx,cy."
        raise FormatError(f"{content} is not a file of cameras that can be read ({told}). {remedy}") from error


_LARGEST_COEFFICIENT = 20.0
"""Of distortion; the numbers in its place are cx and cy, cut in two, where decimals are written with commas."""


def _of_numbers(content: FileContent, numbers: list[float]) -> dict[str, Any]:
    """The camera of numbers alone: a camera matrix of 3 or 4 rows and columns, or of 3 rows and 4 columns; fx fy cx cy,
    without or with 4 or 5 coefficients of distortion after it, or with width and height before it."""
    count = len(numbers)
    if count in {4, 12, 16} or (count == 9 and not (numbers[1] and numbers[3])):
        return {"K": _square(numbers)}
    if count in {6, 11} and numbers[4] < numbers[0] and numbers[5] < numbers[1]:
        return {"size": numbers[:2], "K": numbers[2:6], "distortion": numbers[6:]}
    if count in {8, 9} and abs(numbers[4]) < _LARGEST_COEFFICIENT:
        return {"K": numbers[:4], "distortion": numbers[4:]}
    raise FormatError(
        f"{content} must contain a camera matrix, or fx fy cx cy with decimal points, not {count} numbers."
    )


def _of_colmap(model: str, width: int, height: int, numbers: list[float]) -> dict[str, Any]:
    """A camera of COLMAP, with the keys of nerfstudio, which has its models."""
    numbers = numbers[:1] * (model.startswith("SIMPLE") or "RADIAL" in model) + numbers  # one focal length
    names = "camera_model", "w", "h", "fl_x", "fl_y", "cx", "cy"
    stated = dict(zip(names, (model, width, height, *numbers), strict=False))
    coefficients = numbers[4:]
    return stated | {"distortion": coefficients + [0.0] * (4 - len(coefficients)) if coefficients else []}


def _of_colmap_binary(content: FileContent) -> Any:
    data, at = content.data.tobytes(), 8
    cameras = {}
    with told_as(FormatError, f"{content} is no cameras.bin of COLMAP that can be read.", (struct.error, IndexError)):
        for _ in range(struct.unpack_from("<Q", data)[0]):
            number, model, width, height = struct.unpack_from("<IIQQ", data, at)
            name, count = _COLMAP_MODELS[model]
            cameras[str(number)] = _of_colmap(name, width, height, [*struct.unpack_from(f"<{count}d", data, at + 24)])
            at += 24 + 8 * count
    return cameras


def _of_realsense(streams: list[tuple[str, ...]], place: re.Match[str] | None) -> Any:
    """The intrinsics that rs-enumerate-devices -c prints, by stream and size, and by formats where these differ, and
    where the depth camera is."""
    found: dict[str, dict[str, Any]] = {}
    for stream, size, formats, lines in streams:
        stated = (line.partition(":")[::2] for line in lines.strip().splitlines())
        sizes = found.setdefault(stream, {})
        sizes[f"{size} {formats}" if size in sizes else size] = {name.strip(): value for name, value in stated}
    if place:
        found["depth_to_colour"] = {"rotation, row major": place[1], "translation, metres": place[2]}
    return _parsed(found)


def _number_or_text(text: str) -> float | list[float] | str:
    """A number or several, separated by blanks, or the text itself."""
    try:
        numbers = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers or text


def _parsed(tree: Any) -> Any:
    """A tree with numbers in place of text with numbers, as in KITTI's files."""
    if isinstance(tree, Mapping):
        return {str(key): _parsed(item) for key, item in tree.items()}
    if isinstance(tree, list):
        return [_parsed(item) for item in tree]
    return _number_or_text(re.sub(r"[\[\];]", " ", tree)) if isinstance(tree, str) else tree


def _once(pairs: Iterable[tuple[Any, Any]]) -> dict[str, Any]:
    """A mapping; raises ValueError where a key of a camera, or one with several values, is stated in two ways."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        name = str(key)
        is_unclear = isinstance(value, Mapping | list) or _plain(name.rpartition(".")[2]) in _NAMES
        if is_unclear and found.get(name, value) != value:
            raise ValueError(f"{name} is stated twice, in two ways; keep that of the camera of this image")
        found[name] = value
    return found


class _Loader(yaml.BaseLoader):
    """Mappings, lists and text of YAML, whatever its tags, with so few aliases that they cannot fill the memory."""

    aliases = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self.aliases += self.check_event(yaml.AliasEvent)
        if self.aliases > _MAX_ALIASES:
            raise yaml.YAMLError(f"more than {_MAX_ALIASES} aliases")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[str, Any]:
        return _once((self.construct_object(key, True), self.construct_object(item, True)) for key, item in node.value)


def _of_yaml(text: str) -> Any:
    """YAML, also with tabs, and as OpenCV's FileStorage writes it (whose own reader damaged files can crash)."""
    text = re.sub(r"\A%YAML:.*\n(---.*\n)?", "", text.expandtabs())
    text = re.sub(r"\b(rows|cols|dt|data):(?=\S)", r"\1: ", text)
    if len(text) > _MAX_YAML:
        raise yaml.YAMLError(f"more than {_MAX_YAML >> 10} KiB; keep the part with the camera")
    documents = [one for one in yaml.load_all(text, _Loader) if one is not None]
    return documents[0] if len(documents) == 1 else documents


def _of_sections(text: str) -> Any:
    parser = configparser.RawConfigParser(inline_comment_prefixes="#")
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    parser.read_string(f"[camera]\n{text}")
    return {name: dict(parser[name]) for name in parser.sections()}


def _of_xml(text: str) -> Any:
    """XML, also with several roots, as PCL writes it; within a root of ours, no entities can be declared."""

    def tree(element: ElementTree.Element) -> Any:
        tags = [child.tag for child in element]
        if len(tags) > 1 and len({*tags}) == 1:
            return [tree(child) for child in element]
        return _once((child.tag, tree(child)) for child in element) if tags else element.text or ""

    return tree(ElementTree.fromstring(f"<cameras>{re.sub(r'<[?][^<>]*>', '', text)}</cameras>"))

"""Reading options together: lenses, view, dataset, ground truth, confidence and a guide by name, in every way back."""

import json
from itertools import product
from typing import Any

import cv2
import h5py
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import InputError, ParameterError
from ilf.io.guide_models import add_guide

from ..batch_frames import work_in_this_process
from ..image_files import write_file
from ..io.test_guide_network import brightness
from ..project_states import through_project
from ..small_frames import write_small_frame

COLOUR = ilf.Camera(75.0, 71.0, 40.6, 28.1, size=(80, 60), distortion=(-0.32, 0.11, 0.001, -0.0008, -0.01))
SMALL = ilf.Camera(60.0, 57.0, 30.4, 24.4, size=(64, 48), distortion=(-0.1, 0.02, 0.0, 0.0))
CASES = [
    (undistort, view, camera)
    for undistort, view, camera in product((False, True), ("colour", "depth"), (COLOUR, SMALL))
    if undistort or camera is SMALL or view == "colour"
]
IDS = ["-".join((("bent", "straight")[not how], view, str(camera.size[0]))) for how, view, camera in CASES]


def plane(camera: ilf.Camera, is_bent: bool) -> np.ndarray:
    """Depth [m] of a slanted plane in each pixel of a camera."""
    rows, columns = np.indices(camera.shape, np.float64)
    seen = np.stack([columns.ravel(), rows.ravel()], axis=1)[:, None]
    lens = np.array(camera.distortion) if is_bent else np.zeros(5)
    x, y = cv2.undistortPoints(seen, camera.matrix, lens)[:, 0].T
    return (1 / (0.5 + 0.1 * x + 0.2 * y)).reshape(camera.shape).astype(np.float32)


@pytest.fixture
def given(request, tmp_path, monkeypatch):
    """The arguments of `load_frame` for files of a plane, by one of CASES."""
    undistort, view, camera = request.param
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    monkeypatch.setattr("ilf._runtime.networks.network._networks", {})
    add_guide(brightness(tmp_path / "net.onnx"), "mine", gives="affine")
    shades = np.repeat(np.linspace(20, 230, 80)[None], 60, axis=0).astype(np.uint8)
    write_file(tmp_path / "rgb.png", np.dstack((shades, shades, 255 - shades)))
    write_file(tmp_path / "colour.json", COLOUR.to_json())
    write_file(tmp_path / "depth.json", camera.to_json())
    depth = plane(camera, undistort)
    depth[15:30, 10:25] = np.nan
    with h5py.File(tmp_path / "take.h5", "w") as file:
        file["left/z"], file["right/z"] = depth, 2 * depth
        file["exact"] = plane(camera if view == "depth" else COLOUR, undistort)
    arguments = {
        "rgb": str(tmp_path / "rgb.png"),
        "depth": f"{tmp_path / 'take.h5'}:/left/z",
        "ground_truth": f"{tmp_path / 'take.h5'}:/exact",
        "intrinsics": str(tmp_path / "colour.json"),
        "guide": "mine",
        "view": view,
    }
    if camera is SMALL:
        arguments["depth_intrinsics"] = str(tmp_path / "depth.json")
    if undistort:
        arguments["undistort"] = True
    if camera is COLOUR or view == "depth":
        width, height = camera.size
        np.save(tmp_path / "confidence.npy", np.tile(np.where(np.arange(width) < width // 2, 2, 0), (height, 1)))
        arguments |= {"confidence": str(tmp_path / "confidence.npy"), "min_confidence": 1}
    return arguments


def flat(frame: ilf.RGBDFrame) -> np.ndarray:
    return plane(ilf.Camera(*frame.intrinsics.numbers, size=frame.shape[::-1]), False)


def check_same(found: ilf.RGBDFrame, frame: ilf.RGBDFrame) -> None:
    assert found.inputs == frame.inputs
    assert found.intrinsics.numbers == frame.intrinsics.numbers
    for name in ("rgb", "edge_rgb", "measured", "ground_truth"):
        assert np.array_equal(getattr(found, name), getattr(frame, name), equal_nan=name not in {"rgb", "edge_rgb"})
    assert found.guide.is_same_as(frame.guide)


def check_told(frame: ilf.RGBDFrame, given: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    """`ilf info` tells of this frame."""
    flags = [f"--{name.replace('_', '-')}={value}" for name, value in given.items() if isinstance(value, str)]
    flags = [flag for flag in flags if flag.split("=")[0] not in {"--rgb", "--depth", "--confidence"}]
    undistort = ["--undistort"] if "undistort" in given else []
    assert main(["info", given["rgb"], given["depth"], *flags, *undistort, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["frame"]
    assert facts["problems"] == []
    assert facts["ground_truth"]["known_share"] == np.isfinite(frame.ground_truth).mean()
    assert facts.get("view") == ("depth" if given["view"] == "depth" else None)
    if undistort:
        camera = facts["intrinsics"]
        assert [camera[name] for name in ("fx", "fy", "cx", "cy")] == pytest.approx(frame.intrinsics.numbers)


@pytest.mark.filterwarnings("ignore::ilf.errors.DepthWarning")
@pytest.mark.parametrize("given", CASES, ids=IDS, indirect=True)
def test_a_frame_is_right_is_told_and_comes_back_from_runs_and_projects(given, tmp_path, capsys):
    frame = ilf.load_frame(**given)
    check_told(frame, given, capsys)
    if "confidence" in given:
        without = {name: value for name, value in given.items() if "confidence" not in name}
        check_told(ilf.load_frame(**without), without, capsys)
    assert np.nanmax(np.abs(frame.measured - flat(frame))) < 0.06
    assert np.nanmax(np.abs(frame.ground_truth - flat(frame))) < 0.06
    assert frame.guide.network.name == "mine"
    again = ilf.load_frame(**json.loads(json.dumps(frame.sources)) | {"guide": "mine"})
    check_same(again, frame)
    ilf.complete(frame, max_iterations=2).save(tmp_path / "out", cloud=None)
    replayed = ilf.replay(tmp_path / "out/run.json")
    assert replayed.differences == ()
    check_same(replayed.run.frame, frame)
    assert ilf.load_frame(tmp_path / "out").intrinsics.numbers == pytest.approx(frame.intrinsics.numbers)
    check_same(through_project(frame, tmp_path / "room.ilf"), frame)


@pytest.mark.filterwarnings("ignore::ilf.errors.DepthWarning")
@pytest.mark.parametrize(
    ("given", "static"),
    [((True, "depth", SMALL), ["--static-camera", "1"]), ((True, "colour", SMALL), [])],
    ids=["depth", "colour"],
    indirect=["given"],
)
def test_a_batch_evaluates_undistorted_frames_in_their_own_pixels(given, static, tmp_path, monkeypatch):
    work_in_this_process(monkeypatch)
    for name in ("f0", "f1"):
        folder = tmp_path / "frames" / name
        folder.mkdir(parents=True)
        for file in ("rgb.png", "take.h5"):
            (folder / file).write_bytes((tmp_path / file).read_bytes())
        stated = {"depth": "take.h5:/left/z", "gt": "take.h5:/exact", "depth_units_per_m": 1}
        (folder / "meta.json").write_text(json.dumps(stated))
    names = ("intrinsics", "depth_intrinsics", "view", "guide")
    flags = [text for name in names for text in (f"--{name.replace('_', '-')}", given[name])]
    command = ["batch", str(tmp_path / "frames"), "--out", str(tmp_path / "out"), "--undistort", "--quiet"]
    assert main([*command, *flags, *static, "--max-iterations", "2", "--no-cloud"]) == 0
    replayed = ilf.replay(tmp_path / "out/f1/run.json")
    assert replayed.differences == ()
    frame = replayed.run.frame
    assert np.nanmax(np.abs(frame.ground_truth - flat(frame))) < 0.06
    assert frame.guide.gives == "affine"


def test_what_a_file_gives_is_said_and_a_network_with_a_name_says_it_itself(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    monkeypatch.setattr("ilf._runtime.networks.network._networks", {})
    add_guide(brightness(tmp_path / "net.onnx"), "mine", gives="affine")
    files = [str(path) for path in write_small_frame(tmp_path / "in")]
    np.save(tmp_path / "guide.npy", np.linspace(1, 3, 4800, dtype=np.float32).reshape(60, 80))
    out = tmp_path / "out"
    said = ["--guide", str(tmp_path / "guide.npy"), "--guide-gives", "metric"]
    assert main(["complete", *files, *said, "--out", str(out), "--max-iterations", "2"]) == 0
    run = ilf.replay(out / "run.json").run
    assert run.frame.guide.gives == "metric"
    assert ilf.load_frame(*files, guide=tmp_path / "net.onnx", guide_gives="affine").guide.gives == "affine"
    assert ilf.load_frame(*files, guide="mine", guide_gives="affine").guide.network.name == "mine"
    with pytest.raises(InputError, match=r"mine gives affine, not metric\. Leave "):
        ilf.load_frame(*files, guide="mine", guide_gives="metric")
    with pytest.raises(ParameterError, match="affine or metric, not 'depth'"):
        ilf.load_frame(*files, guide="mine", guide_gives="depth")
    capsys.readouterr()
    assert main(["info", *files, "--guide", "mine", "--guide-gives", "metric", "--json"]) == 0
    assert "mine gives affine, not metric" in json.loads(capsys.readouterr().out)["frame"]["problems"][0]
    with pytest.warns(ilf.DepthWarning, match="There is no guide"):
        assert "There is no guide" in ilf.load_frame(*files, guide_gives="affine").notes[-1]


def test_a_folder_of_frames_has_guides_of_one_kind(tmp_path):
    for name in ("f0", "f1"):
        write_small_frame(tmp_path / name)
        (tmp_path / name / "meta.json").write_text('{"depth_units_per_m": 1000}')
        np.save(tmp_path / name / "guide.npy", np.linspace(1, 3, 4800, dtype=np.float32).reshape(60, 80))
    source = ilf.open_source(tmp_path, guide_gives="affine-inverse")
    assert [source.read(key).guide.gives for key in source.keys] == ["affine-inverse"] * 2

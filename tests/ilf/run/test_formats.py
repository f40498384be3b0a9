"""Files of other programs, read back by code that shares nothing with their writers, and by this program's readers."""

import errno
import hashlib
import json
import sys
import tarfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image, ImageDraw

import ilf
from ilf.cli import main
from ilf.data.blocks import BlockInfo, block_colour
from ilf.data.results import compose
from ilf.errors import ExportError, InputError, ParameterError
from ilf.io.block_files import read_blocks
from ilf.io.cameras import frame_camera, intrinsics_from
from ilf.io.depth import read_depth_values
from ilf.io.encodings import encoding_of
from ilf.io.polygons import compressed, run_lengths
from ilf.run.formats import FORMATS
from ilf.run.options import ExportOptions
from ilf.run.writing import write

from ..batch_frames import work_in_this_process
from ..small_frames import CAMERA, QUICK, write_small_frame
from ..small_runs import contents, small_run

NAMES = {1: "a/../../etc <b>&amp;</b>", 7: 'Stuhl „é“ \\ "x"\t: - # *', 200: "%YAML 1.2 --- !!python/none {}"}
"""Names that would be a path, markup or syntax somewhere."""

OWN_COLOUR = (1, 2, 3)


def odd_labels(shape):
    """A ring around a hole with a block in it, a block of two pieces, one of a pixel, and pixels of none."""
    labels = np.zeros(shape, np.int32)
    labels[5:30, 5:30] = 1
    labels[10:20, 10:20] = 0
    labels[12:15, 12:15] = 7
    labels[40:50, 2:9] = labels[35:38, 60:75] = 200
    labels[50:55, 9:12] = 200  # touches its other piece at a corner
    labels[58, 78] = 255
    return labels


@pytest.fixture
def completion(tmp_path):
    run = small_run(tmp_path)
    infos = {label: BlockInfo(name, block_colour(label)) for label, name in NAMES.items()}
    infos[255] = BlockInfo("Block 255", OWN_COLOUR)
    labels = odd_labels(run.frame.shape)
    return compose(replace(run, blocks=replace(run.blocks, labels=labels, infos=infos)), {})


@pytest.fixture
def out(completion, tmp_path):
    """A folder with the file of every format."""
    written = completion.save(tmp_path / "out", exports=tuple(FORMATS))
    assert not written.notes
    return tmp_path / "out"


def test_depth_is_read_back_with_its_missing_pixels(completion, out):
    depth = completion.depth
    assert np.isnan(depth).any()
    np.testing.assert_array_equal(read_depth_values(out / "depth.exr"), depth)
    raw = np.asarray(Image.open(out / "depth.tum.png"))
    np.testing.assert_array_equal(raw == 0, np.isnan(depth))
    np.testing.assert_allclose(raw / 5000, np.nan_to_num(depth), atol=0.0001001)
    again = encoding_of("tum").metres(read_depth_values(out / "depth.tum.png"))
    np.testing.assert_allclose(again, depth, atol=0.0001001)


def test_depth_that_does_not_fit_is_said(completion, tmp_path):
    far = replace(completion, depth=np.full_like(completion.depth, 14))
    (note,) = far.export(tmp_path / "far.tum.png")
    assert note.startswith("far.tum.png: Depth beyond 13.11 m")
    note = far.save(tmp_path / "far", depth_formats=("npy",), exports=("tum.png",)).notes[-1]
    assert note.startswith("depth.tum.png: Depth beyond 13.11 m")


def test_a_palette_has_the_labels_and_the_colours_of_the_blocks(completion, out):
    labels = completion.run.blocks.labels
    with Image.open(out / "blocks.palette.png") as image:
        assert image.mode == "P"
        np.testing.assert_array_equal(np.asarray(image), labels)
        colours = np.asarray(image.convert("RGB"))
    for label in (1, 7, 200):
        assert (colours[labels == label] == block_colour(label)).all()
    assert (colours[labels == 255] == OWN_COLOUR).all()
    assert (colours[labels == 0] == 0).all()
    np.testing.assert_array_equal(read_blocks(out / "blocks.palette.png", labels.shape).labels, labels)


def test_coco_has_run_lengths_boxes_areas_and_names(completion, out):
    labels, content = completion.run.blocks.labels, json.loads((out / "blocks.coco.json").read_text())
    (image,) = content["images"]
    assert (image["file_name"], image["width"], image["height"]) == ("rgb.png", 80, 60)
    categories = {one["id"]: one["name"] for one in content["categories"]}
    found = read_blocks(out / "blocks.coco.json", labels.shape)
    np.testing.assert_array_equal(found.labels, labels)
    assert sorted(one["id"] for one in content["annotations"]) == [1, 7, 200, 255]
    for one in content["annotations"]:
        mask = labels == one["id"]
        rows, columns = np.nonzero(mask)
        assert one["segmentation"] == {"size": [60, 80], "counts": compressed(run_lengths(mask))}
        x, y, width, height = one["bbox"]
        assert (x, x + width - 1, y, y + height - 1) == (columns.min(), columns.max(), rows.min(), rows.max())
        assert one["area"] == mask.sum()
        assert one["image_id"] == image["id"]
        assert categories[one["category_id"]] == NAMES.get(one["id"], "block")
    assert found.names == {label: " ".join(name.split()) for label, name in NAMES.items()}


def test_labelme_has_polygons_that_fill_the_blocks(completion, out):
    labels, content = completion.run.blocks.labels, json.loads((out / "blocks.labelme.json").read_text())
    assert (out / content["imagePath"]).resolve() == Path(completion.frame.inputs.rgb.path)
    assert (content["imageHeight"], content["imageWidth"], content["imageData"]) == (60, 80, None)
    groups = {shape["group_id"] for shape in content["shapes"]}
    assert groups == {1, 7, 200, 255}
    for label in groups:
        shapes = [shape for shape in content["shapes"] if shape["group_id"] == label]
        picture = Image.new("1", (80, 60))
        for shape in shapes:
            assert (shape["shape_type"], shape["label"]) == ("polygon", NAMES.get(label, "block"))
            ImageDraw.Draw(picture).polygon([tuple(point) for point in shape["points"]], fill=1, outline=1)
        wrong = np.asarray(picture) != (labels == label)
        block = (labels == label).astype(np.uint8)
        near = cv2.dilate(block, np.ones((3, 3))) != cv2.erode(block, np.ones((3, 3)))
        assert not (wrong & ~near).any()
    assert len([shape for shape in content["shapes"] if shape["group_id"] == 200]) == 3
    found = read_blocks(out / "blocks.labelme.json", labels.shape)
    np.testing.assert_array_equal(found.labels, labels)


def test_the_colour_of_a_recording_is_beside_the_files(completion, tmp_path):
    inputs = replace(completion.frame.inputs, frame="12.5")
    of_recording = replace(completion, run=replace(completion.run, frame=replace(completion.frame, inputs=inputs)))
    of_recording.save(tmp_path / "bag", exports=("labelme.json", "coco.json"))
    assert json.loads((tmp_path / "bag/blocks.labelme.json").read_text())["imagePath"] == "rgb.png"
    assert (tmp_path / "bag/rgb.png").exists()
    of_recording.export(tmp_path / "alone.labelme.json")
    assert json.loads((tmp_path / "alone.labelme.json").read_text())["imagePath"] == ""


def test_the_camera_is_read_by_those_whose_format_it_is(out):
    numbers, matrix = (80, 76, 41.3, 27.8), [[80, 0, 41.3], [0, 76, 27.8], [0, 0, 1]]
    storage = cv2.FileStorage(str(out / "camera.opencv.yaml"), cv2.FileStorage_READ)
    np.testing.assert_array_equal(storage.getNode("camera_matrix").mat(), matrix)
    np.testing.assert_array_equal(storage.getNode("distortion_coefficients").mat(), np.zeros((1, 5)))
    assert [storage.getNode(f"image_{name}").real() for name in ("width", "height")] == [80, 60]
    info = yaml.safe_load((out / "camera_info.yaml").read_text())
    assert (info["image_width"], info["image_height"], info["distortion_model"]) == (80, 60, "plumb_bob")
    assert np.reshape(info["camera_matrix"]["data"], (3, 3)).tolist() == matrix
    assert np.reshape(info["projection_matrix"]["data"], (3, 4))[:, :3].tolist() == matrix
    of_open3d = json.loads((out / "camera.json").read_text())
    assert np.reshape(of_open3d["intrinsic_matrix"], (3, 3), order="F").tolist() == matrix
    assert [of_open3d[name] for name in ("width", "height", "fx", "fy", "cx", "cy")] == [80, 60, *numbers]
    for name in ("camera.json", "camera.opencv.yaml", "camera_info.yaml"):
        assert intrinsics_from(out / name, (60, 80)).numbers == numbers
        camera, notes = frame_camera(str(out / name), (120, 160))
        assert camera.numbers == pytest.approx((160, 152, 83.1, 56.1))
        assert len(notes) == 1  # that it is scaled; nothing of a lens


def test_the_folder_is_still_a_frame_and_its_record_has_all_files(completion, out, tmp_path, cli):
    again = ilf.load_frame(out)
    np.testing.assert_array_equal(again.depth, completion.depth)
    record = json.loads((out / "run.json").read_text())
    assert record["export"]["exports"] == [*FORMATS]
    for format in FORMATS.values():
        assert record["outputs"][format.file] == hashlib.sha256((out / format.file).read_bytes()).hexdigest()
    assert ilf.open_source(out.parent).keys == ("in",)
    completion.save(tmp_path / "plain")
    assert json.loads((tmp_path / "plain/run.json").read_text())["export"]["exports"] == []
    assert "interrupted" not in cli("info", out).out


def small_files(tmp_path):
    return [*map(str, write_small_frame(tmp_path / "frames" / "one")), "--intrinsics", CAMERA]


SHORT = ["--preset", "best", "--max-iterations", "3", "--no-cloud", "--quiet"]
EVERY = [word for name in FORMATS for word in ("--export", name)]


def test_the_command_line_writes_the_same_files_in_folders_files_and_batches(tmp_path, monkeypatch):
    work_in_this_process(monkeypatch)
    files, names = small_files(tmp_path), {format.file for format in FORMATS.values()}
    single = [word for name in FORMATS for word in ("--export", str(tmp_path / "single" / FORMATS[name].file))]
    assert main(["complete", *files, "--out", str(tmp_path / "out"), *SHORT, *EVERY, *single]) == 0
    batch = ["batch", str(tmp_path / "frames"), "--intrinsics", CAMERA, *SHORT, *EVERY]
    assert main([*batch, "--out", str(tmp_path / "all")]) == 0
    (of_batch,) = (path for path in (tmp_path / "all").iterdir() if path.is_dir())
    record = str(tmp_path / "out/run.json")
    assert main(["complete", "--replay", record, "--out", str(tmp_path / "again"), "--quiet"]) == 0
    expected = {name: content for name, content in contents(tmp_path / "out").items() if name in names}
    assert expected.keys() == names
    for folder in ("single", of_batch, "again"):
        found = contents(tmp_path / folder)
        assert names <= found.keys()
        assert {name for name in names if found[name] != expected[name]} <= {"blocks.labelme.json"}
    assert contents(tmp_path / "single").keys() == names


def test_shards_have_the_files(tmp_path, monkeypatch):
    work_in_this_process(monkeypatch)
    small_files(tmp_path)
    batch = ["batch", str(tmp_path / "frames"), "--intrinsics", CAMERA, "--max-iterations", "3", "--quiet", *EVERY]
    out = tmp_path / "shards"
    assert main([*batch, "--shards", str(out), "--keep", "depth,blocks,rgb"]) == 0
    (tar,) = out.glob("*.tar")
    with tarfile.open(tar) as files:
        found = {name.partition(".")[2]: files.extractfile(name).read() for name in files.getnames()}
        (colour,) = (name for name in files.getnames() if name.endswith(".rgb.png"))
    assert {format.file for format in FORMATS.values()} <= found.keys()
    labels = cv2.imdecode(np.frombuffer(found["blocks.png"], np.uint8), cv2.IMREAD_UNCHANGED)
    for name in ("blocks.palette.png", "blocks.coco.json", "blocks.labelme.json"):
        (tmp_path / name).write_bytes(found[name])
        np.testing.assert_array_equal(read_blocks(tmp_path / name, labels.shape).labels, labels)
    assert json.loads(found["blocks.labelme.json"])["imagePath"] == colour
    assert main(["batch", "--shards", str(out), "--verify", "--quiet"]) == 0
    assert ilf.open_source(out)[0].shape == labels.shape


def test_what_cannot_be_made_is_refused_or_left_out(completion, tmp_path, cli, monkeypatch):
    work_in_this_process(monkeypatch)
    blocks = replace(completion.run.blocks, labels=completion.run.blocks.labels * 300)
    frame = replace(completion.frame, intrinsics=None)
    run = replace(completion.run, frame=frame, blocks=blocks)
    found = compose(run, {})
    for name, why in (("palette.png", "0 to 255, not 76500"), ("camera.json", "no camera")):
        with pytest.raises(InputError, match=why):
            found.save(tmp_path / "out", exports=(name,))
        with pytest.raises(InputError, match=why):
            found.export(tmp_path / "out" / f"x.{name}")
    assert not (tmp_path / "out").exists()
    frames = write_small_frame(tmp_path / "frames" / "one")
    alone = ["complete", *map(str, frames), "--export", f"{tmp_path}/x.opencv.yaml", "--out", f"{tmp_path}/no"]
    assert "no camera intrinsics" in cli(*alone, status=1).err
    batch = ["batch", str(tmp_path / "frames"), *SHORT, "--export", "camera.json", "--export", "coco.json"]
    assert main([*batch, "--out", str(tmp_path / "all")]) == 0
    (folder,) = (path for path in (tmp_path / "all").iterdir() if path.is_dir())
    assert not (folder / "camera.json").exists()
    assert (folder / "blocks.coco.json").exists()
    manifest = (tmp_path / "all/manifest.csv").read_text()
    assert "No camera.json is written. The frame has no camera intrinsics" in manifest


def test_unknown_formats_are_refused(tmp_path, capsys, cli):
    with pytest.raises(ParameterError, match=r"exports must be a list, any of exr, tum\.png, .*'jpg'"):
        ExportOptions(exports=("jpg",))
    assert "no export with this extension" in cli("complete", *small_files(tmp_path), "--export", "coco", status=1).err
    assert main(["batch", str(tmp_path / "frames"), "--out", str(tmp_path / "all"), "--export", "x.coco.json"]) == 2
    assert "--export takes a format here, not 'x.coco.json': exr, " in capsys.readouterr().err


def test_without_openexr_the_file_is_said_to_need_it(completion, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(InputError, match=r"Writing EXR needs the package OpenEXR.*ilf-studio\[sensors\]"):
        completion.save(tmp_path / "out", exports=("exr",))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("number", "problem"), [(errno.ENOSPC, "the disk is full"), (errno.EROFS, "read-only")])
def test_a_full_or_read_only_disk_leaves_what_was_there(completion, out, tmp_path, monkeypatch, number, problem):
    completion.export(tmp_path / "one.coco.json")
    before, one = contents(out), (tmp_path / "one.coco.json").read_bytes()
    real = Path.write_bytes

    def write_bytes(path, content):
        if content.startswith(b'{"images"'):
            raise OSError(number, "failed")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", write_bytes)
    with pytest.raises(ExportError, match=problem):
        write(out, completion, ExportOptions(exports=("exr", "coco.json")))
    with pytest.raises(ExportError, match=problem):
        completion.export(tmp_path / "one.coco.json")
    assert contents(out) == before
    assert (tmp_path / "one.coco.json").read_bytes() == one


def test_a_file_is_never_one_of_the_frames_own(tmp_path):
    rgb, depth = write_small_frame(tmp_path)
    own = depth.rename(tmp_path / "depth.tum.png")
    frame = ilf.load_frame(rgb, own)
    completion = ilf.complete(frame, **QUICK)
    before = own.read_bytes()
    with pytest.raises(ExportError, match="own file"):
        completion.save(tmp_path, exports=("tum.png",), depth_formats=())
    with pytest.raises(ExportError, match="own file"):
        completion.export(own)
    assert own.read_bytes() == before

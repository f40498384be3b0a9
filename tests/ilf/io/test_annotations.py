"""Blocks from and to other programs: the same label map again, files as those programs write them, and bad ones."""

import base64
import json
import tracemalloc
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ilf.errors import ExportError, FormatError, InputError
from ilf.io.block_files import BLOCK_FORMATS, read_blocks, write_blocks
from ilf.io.polygons import compressed, filled_polygon, outline_polygons, run_lengths

SHAPE = (4, 6)
MAPS = hnp.arrays(
    np.int32, hnp.array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.sampled_from([0, 1, 2, 65535])
)
"""Small maps of few blocks: of many parts that touch at corners, with holes in holes."""


def square(x: int, y: int, size: int) -> list[list[float]]:
    return [[x, y], [x + size, y], [x + size, y + size], [x, y + size]]


def shape_of(points: list, label: str = "chair", **others: object) -> dict:
    return {"label": label, "points": points, "group_id": None, "shape_type": "polygon", "flags": {}, **others}


def labelme(*shapes: dict, **others: object) -> dict:
    return {
        "version": "5.5.0",
        "flags": {},
        "shapes": list(shapes),
        "imagePath": "rgb.jpg",
        "imageData": None,
        "imageHeight": SHAPE[0],
        "imageWidth": SHAPE[1],
        **others,
    }


def coco(*segmentations: object, **others: object) -> dict:
    annotations = [
        {"id": 900 + number, "image_id": 7, "category_id": 3, "segmentation": one, "iscrowd": 0}
        for number, one in enumerate(segmentations)
    ]
    return {
        "images": [{"id": 7, "file_name": "rgb.jpg", "height": SHAPE[0], "width": SHAPE[1]}],
        "annotations": annotations,
        "categories": [{"id": 3, "name": "chair"}],
        **others,
    }


def saved(folder: Path, content: object) -> Path:
    path = folder / "blocks.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize("format", BLOCK_FORMATS)
@settings(max_examples=30)
@given(labels=MAPS)
@example(labels=np.array([[0, 255], [1, 255]], np.int32))
def test_the_same_map_comes_back_from_every_format(format, labels, tmp_path_factory):
    assume(format != "palette" or labels.max() < 256)
    suffix = BLOCK_FORMATS[format][1]
    path = tmp_path_factory.getbasetemp() / f"blocks{suffix}"
    names = {} if suffix == ".png" else {int(label): f"Näme {label}" for label in np.unique(labels) if label > 1}
    write_blocks(path, labels, format=format, names=names)
    found = read_blocks(path, labels.shape)
    np.testing.assert_array_equal(found.labels, labels)
    assert found.names == names
    # nothing was left out, covered or lost
    assert not [note for note in found.notes if "contains no blocks" not in note]


@given(labels=MAPS)
def test_a_part_is_one_polygon_along_the_edges_of_its_pixels(labels):
    from skimage.measure import label as connected_regions

    for label, polygons in outline_polygons(labels).items():
        assert len(polygons) == connected_regions(labels == label, connectivity=1).max()
        for points in polygons:
            steps = points - np.roll(points, 1, axis=0)
            assert np.all((steps == 0).sum(axis=1) == 1)


def test_run_lengths_go_down_the_columns_and_their_text_is_cocos(tmp_path):
    mask = np.array([[0, 1, 0], [0, 1, 1]], bool)
    assert run_lengths(mask) == [2, 2, 1, 1]
    assert run_lengths(~mask) == [0, 2, 2, 1, 1]
    # 5 bits a character, the lowest first; from the fourth on the difference to the one before the last, here 3 - 6
    assert compressed([0, 1024]) == "0PP1"
    assert compressed([0, 6, 1, 3]) == "061M"
    for counts in ([2, 2, 1, 1], "221O"):
        content = coco({"size": [2, 3], "counts": counts}, images=[])
        found = read_blocks(saved(tmp_path, content), (2, 3))
        np.testing.assert_array_equal(found.labels > 0, mask)


def test_labelmes_shapes(tmp_path):
    mask = cv2.imencode(".png", np.array([[1, 0], [1, 1]], np.uint8))[1].tobytes()
    content = labelme(
        shape_of([[0, 0], [2, 1]], "shelf", shape_type="rectangle"),
        shape_of([[4.5, 0.5], [4.5, 1.2]], "lamp", shape_type="circle"),
        shape_of(square(0, 2, 1), "table", group_id=4),
        shape_of(square(2, 2, 1), "table", group_id=4),
        shape_of([[4, 2], [5, 3]], "cup", shape_type="mask", mask=base64.b64encode(mask).decode()),
        shape_of([[1, 1], [2, 2]], "crack", shape_type="line"),
        shape_of([[1, 1]], "nail", shape_type="point"),
        imageData="never looked at",
    )
    found = read_blocks(saved(tmp_path, content), SHAPE)
    assert found.labels.tolist() == [[1, 1, 0, 0, 2, 0], [0, 0, 0, 0, 0, 0], [4, 0, 4, 0, 3, 0], [0, 0, 0, 0, 3, 3]]
    assert found.names == {1: "shelf", 2: "lamp", 4: "table", 3: "cup"}
    assert found.notes == ("Left out shapes without an area: 1 line, 1 point.",)


@pytest.mark.parametrize("first", [0, 1])
def test_group_ids_of_no_block_or_that_several_labels_share_are_no_numbers(tmp_path, first):
    chair, table = shape_of(square(0, 0, 1), "chair", group_id=first), shape_of(square(2, 0, 1), "table", group_id=1)
    content = labelme(chair, table)
    found = read_blocks(saved(tmp_path, content), SHAPE)
    assert found.names == {1: "chair", 2: "table"}


def test_where_shapes_overlap_the_smallest_lies_on_top_whatever_their_order(tmp_path):
    large, small = shape_of([[0, 0], [6, 0], [6, 4], [0, 4]], "wall"), shape_of(square(1, 1, 2), "picture")
    for shapes in ((large, small), (small, large)):
        found = read_blocks(saved(tmp_path, labelme(*shapes)), SHAPE)
        names = {label: found.names[label] for label in (1, 2)}
        assert names[found.labels[1, 1]] == "picture"
        assert names[found.labels[0, 0]] == "wall"
        assert found.notes == ("In several shapes: 4 pixels, of which the smallest shape is used.",)
    found = read_blocks(saved(tmp_path, labelme(small, small, shape_of(square(0, 0, 0)))), SHAPE)
    assert any("1 shape left out: smaller shapes cover all pixels" in note for note in found.notes)
    assert any("1 shape left out: no pixel centre" in note for note in found.notes)


def test_cocos_annotations_keep_ids_and_categories(tmp_path):
    content = coco([[0, 0, 2, 0, 2, 2, 0, 2], [4, 2, 6, 2, 6, 4]], {"size": [4, 6], "counts": [12, 4, 8]}, [])
    found = read_blocks(saved(tmp_path, content), SHAPE)
    assert found.labels.tolist() == [
        [900, 900, 0, 901, 0, 0],
        [900, 900, 0, 901, 0, 0],
        [0, 0, 0, 901, 900, 900],
        [0, 0, 0, 901, 0, 900],
    ]
    assert found.names == {900: "chair", 901: "chair"}
    assert found.notes == ("Left out 1 annotation without an outline, such as boxes.",)


def test_of_several_images_that_of_the_colour_files_name_is_taken(tmp_path):
    images = [{"id": number, "file_name": f"{name}/rgb.jpg"} for number, name in enumerate(["kitchen", "hall"])]
    content = coco([[0, 0, 2, 0, 2, 2, 0, 2]], [[2, 2, 4, 2, 4, 4, 2, 4]], images=images)
    for number, one in enumerate(content["annotations"]):
        one["image_id"] = number
    path = saved(tmp_path, content)
    assert read_blocks(path, SHAPE, image="/frames/hall/rgb.jpg").labels[2, 2] == 901
    for image in (None, "/frames/cellar/rgb.jpg"):
        with pytest.raises(InputError, match=r"2 images \('kitchen/rgb.jpg', 'hall/rgb.jpg'\)"):
            read_blocks(path, SHAPE, image=image)


def test_masks_of_segment_anything_as_json_and_as_folder(tmp_path):
    masks = np.zeros((3, *SHAPE), np.uint8)
    masks[0, :, :3], masks[1, 1:3, 1:3], masks[2, :, 5] = 1, 1, 1
    expected = np.array([[1, 1, 1, 0, 0, 3], [1, 2, 2, 0, 0, 3], [1, 2, 2, 0, 0, 3], [1, 1, 1, 0, 0, 3]])
    listed = [
        {"segmentation": {"size": [*SHAPE], "counts": compressed(run_lengths(mask > 0))}, "area": 1, "bbox": [0] * 4}
        for mask in masks
    ]
    image = {"image_id": 5, "height": SHAPE[0], "width": SHAPE[1], "file_name": "sa_5.jpg"}
    for content in (listed, {"image": image, "annotations": listed}):
        np.testing.assert_array_equal(read_blocks(saved(tmp_path, content), SHAPE).labels, expected)
    folder = tmp_path / "masks"
    folder.mkdir()
    for number, mask in enumerate(masks):
        cv2.imwrite(str(folder / f"{number}.png"), mask * 255)
    found = read_blocks(folder, SHAPE)
    np.testing.assert_array_equal(found.labels, expected)
    assert found.names == {}
    cv2.imwrite(str(folder / "0matting.png"), np.random.default_rng(1).integers(0, 255, (*SHAPE, 3), np.uint8))
    with pytest.raises(InputError, match=r"0matting.png is a colour image"):
        read_blocks(folder, SHAPE)
    (folder / "0matting.png").unlink()
    (folder / "2.png").rename(folder / "door frame.png")
    assert read_blocks(folder, SHAPE).names == {3: "door frame"}


SQUARE = square(0, 0, 2)
GREY, COLOURED = (
    base64.b64encode(cv2.imencode(".png", np.ones(shape, np.uint8))[1]).decode() for shape in ((2, 2), (2, 2, 3))
)
BAD = {
    "broken": ("{", "not valid JSON"),
    "nested": ("[" * 100_000, "not valid JSON"),
    "other": ({"a": 1}, "not that of labelme or COCO"),
    "size": (labelme(imageWidth=7), "7 x 4, but the frame is 6 x 4"),
    "coco size": (coco(images=[{"id": 7, "file_name": "a.jpg", "height": 9, "width": 6}]), "6 x 9, but the frame"),
    "no shape": (labelme("chair"), "shape 1 is not a JSON object"),
    "nan": (labelme(shape_of([*SQUARE, [float("nan"), 1]])), r"shape 1 \('chair'\) has a point that is not finite"),
    "huge number": (labelme(shape_of([*SQUARE, [10**400, 1]])), "not pairs of numbers"),
    "words": (labelme(shape_of(["a", "b"])), "not pairs of numbers"),
    "ragged": (labelme(shape_of([[1, 2], [3]])), "not pairs of numbers"),
    "no points": (labelme(shape_of(None)), "has no list of points"),
    "off": (labelme(shape_of(square(50, 2, 2))), "lies outside the image, which is 6 x 4"),
    "fractions": (coco([[0.1, 0.1, 0.9, 0.1, 0.9, 0.9]]), "fractions of the image, from 0 to 1. Export them in pixels"),
    "far": (labelme(shape_of([*SQUARE, [1e300, 1]])), "lies outside the image"),
    "many points": (coco([[0, 1] * 100_001]), "annotation 900 .'chair'. has more points than"),
    "circle": (labelme(shape_of(SQUARE, shape_type="circle")), "circle with 4 points instead of 2"),
    "mask": (labelme(shape_of([[0, 0], [1, 1]], shape_type="mask", mask="!")), "no readable mask"),
    "empty mask": (labelme(shape_of([[0, 0], [1, 1]], shape_type="mask", mask="")), "shape 1"),
    "mask beyond": (labelme(shape_of([[5, 3], [7, 5]], shape_type="mask", mask=GREY)), "beyond the image of 6 x 4"),
    "colour mask": (labelme(shape_of(SQUARE[:2], shape_type="mask", mask=COLOURED)), "Export it with one channel"),
    "run sum": (coco({"size": [4, 6], "counts": [12, 4]}), "do not add up to the image's 24 pixels"),
    "run length": (coco({"size": [4, 6], "counts": [12, 10**30]}), "do not add up"),
    "many runs": (coco({"size": [4, 6], "counts": [0] * 100 + [24]}), "do not add up"),
    "run sign": (coco({"size": [4, 6], "counts": [30, -6]}), "do not add up"),
    "run number": (coco({"size": [4, 6], "counts": [1.5, True]}), "neither integers"),
    "run text": (coco({"size": [4, 6], "counts": "0\u00e9"}), "damaged"),
    "cut text": (coco({"size": [4, 6], "counts": "P"}), "damaged"),
    "long text": (coco({"size": [4, 6], "counts": "oooooooooo0"}), "damaged"),
    "empty text": (coco({"size": [4, 6], "counts": ""}), "damaged"),
    "run size": (coco({"size": [10**9, 10**9], "counts": [10**18]}), "the frame is 6 x 4"),
    "annotations": (coco(annotations=3), "not a list of annotations"),
    "images": (coco(images=3), "not a list of images"),
    "segmentation": (coco("abc"), "neither a list of polygons nor run lengths"),
    "several": ([{"image_id": 1, "segmentation": []}, {"image_id": 2, "segmentation": []}], "several images"),
    "too many": (coco(*[[[0, 0, 1, 0, 1, 1]]] * 65_536), "more than 65535"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_one_sentence(name, tmp_path):
    content, message = BAD[name]
    path = saved(tmp_path, content)
    with pytest.raises(InputError, match=message) as caught:
        read_blocks(path, SHAPE)
    assert str(path) in str(caught.value)


def test_a_line_that_crosses_the_image_too_often_is_refused(tmp_path):
    shape = (1000, 3)
    zigzag = labelme(shape_of([[1, 0], [2, 1000]] * 50_000), imageHeight=1000, imageWidth=3)
    with pytest.raises(InputError, match="too often"):
        read_blocks(saved(tmp_path, zigzag), shape)


def test_a_line_that_crosses_the_image_often_is_filled_in_bounded_memory():
    """Of a small file."""
    height, width = 1500, 2000
    x = np.linspace(0.0, width, 3800)
    zigzag = np.column_stack((x, np.where(np.arange(x.size) % 2, 0.0, height)))
    tracemalloc.start()
    part = filled_polygon(zigzag, "a line", (height, width))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert part is not None
    assert part.mask.mean() == pytest.approx(1 / 3, abs=0.01)
    assert peak < 250e6


def test_folders_and_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match="contains no masks"):
        read_blocks(tmp_path, SHAPE)
    cv2.imwrite(str(tmp_path / "a.png"), np.ones((9, 9), np.uint8))
    with pytest.raises(InputError, match="the mask is 9 x 9, but the frame is 6 x 4"):
        read_blocks(tmp_path, SHAPE)
    (tmp_path / "c.txt").write_text("hello")
    with pytest.raises(FormatError, match="not a PNG"):
        read_blocks(tmp_path / "c.txt", SHAPE)
    with pytest.raises(InputError, match="no such file"):
        read_blocks(tmp_path / "d", SHAPE)


def test_what_cannot_be_written_is_said(tmp_path):
    labels = np.ones(SHAPE, np.int32)
    for path, format, message in (
        ("a.txt", None, "use .png or .json"),
        ("a.json", "xml", "use one of png, palette, coco"),
        ("a.png", "coco", "use .json"),
        ("a.json", "png", "use .png"),
    ):
        with pytest.raises(ExportError, match=message):
            write_blocks(tmp_path / path, labels, format=format)
    with pytest.raises(ExportError, match="0 to 65535"):
        write_blocks(tmp_path / "a.json", labels * 70_000)
    with pytest.raises(ExportError, match="the labels 0 to 255, not 256: use a label map of 16 bits"):
        write_blocks(tmp_path / "a.png", labels * 256, format="palette")
    assert not list(tmp_path.iterdir())

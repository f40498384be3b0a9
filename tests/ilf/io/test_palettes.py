"""Images with a palette: indices are the values of label maps and masks, colours those of colour images."""

import base64
import json
import zlib

import numpy as np
import pytest
from PIL import Image

from ilf.errors import FormatError
from ilf.io.block_files import read_blocks
from ilf.io.frame_additions import read_confidence
from ilf.io.images import read_colour, read_labels, read_mask
from tests.ilf.depth_files import pillow

INDICES = np.array([[0, 1, 1, 2], [0, 3, 3, 1]], np.uint8)
COLOURS = {
    "colours": [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0],
    "grey": [0, 0, 0, 80, 80, 80, 160, 160, 160, 240, 240, 240],
    "white first": [255, 255, 255, 0, 0, 0, 9, 9, 9, 70, 70, 70],
    "equal": [7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7],
}


def palette(colours: list[int], bits: int = 8, indices: np.ndarray = INDICES, fmt: str = "PNG", **options) -> bytes:
    """An image of these indices; `bits` is the number of bits that each has in a PNG."""
    image = Image.fromarray(indices, "P")
    image.putpalette(colours[: 3 * 2**bits])
    return pillow(image, fmt, **({"bits": bits} if fmt == "PNG" else {}), **options)


@pytest.mark.parametrize("bits", [2, 4, 8])
@pytest.mark.parametrize("colours", COLOURS.values(), ids=list(COLOURS))
def test_indices_are_labels(colours, bits, tmp_path):
    file = tmp_path / "labels.png"
    file.write_bytes(palette(colours, bits, transparency=0))
    assert np.array_equal(read_labels(file), INDICES)
    assert np.array_equal(read_blocks(file, INDICES.shape).labels, INDICES)
    assert np.array_equal(read_mask(file), INDICES > 0)
    assert np.array_equal(read_confidence(file, INDICES.shape), INDICES)


def test_a_palette_of_one_bit_is_a_mask_also_in_folders_and_labelme(tmp_path):
    mask = (INDICES == 1).astype(np.uint8)
    data = palette(COLOURS["colours"], 1, mask)
    (tmp_path / "chair.png").write_bytes(data)
    assert np.array_equal(read_mask(tmp_path / "chair.png"), mask > 0)
    found = read_blocks(tmp_path, mask.shape)
    assert np.array_equal(found.labels, mask)
    assert found.names == {1: "chair"}
    shape = {"shape_type": "mask", "label": "x", "points": [[0, 0], [3, 1]], "mask": base64.b64encode(data).decode()}
    content = {"shapes": [shape], "imageHeight": 2, "imageWidth": 4}
    (tmp_path / "labelme.json").write_text(json.dumps(content))
    assert np.array_equal(read_blocks(tmp_path / "labelme.json", mask.shape).labels, mask)


def test_many_indices_and_other_formats(tmp_path):
    many = np.tile(np.arange(256, dtype=np.uint8).reshape(16, 16), (8, 8))
    colours = np.random.default_rng(0).integers(0, 255, 768).tolist()
    (tmp_path / "labels.png").write_bytes(palette(colours, indices=many))
    (tmp_path / "labels.tif").write_bytes(palette(colours, indices=many, fmt="TIFF"))
    for file in tmp_path.iterdir():
        assert np.array_equal(read_labels(file), many)
        assert "picture" in " ".join(read_blocks(file, many.shape).notes)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_grey_of_few_bits_is_not_scaled(bits, tmp_path):
    values = np.arange(2**bits, dtype=np.uint8).reshape(2, -1)
    data = palette(COLOURS["colours"] * 4, bits, values)
    header, colours = data.index(b"IHDR") + 4, data.index(b"PLTE") - 4
    grey = bytearray(data)
    grey[header + 9] = 0  # the type of colour: grey in place of a palette
    grey[header + 13 : header + 17] = zlib.crc32(grey[header - 4 : header + 13]).to_bytes(4)
    del grey[colours : colours + 12 + int.from_bytes(data[colours : colours + 4])]
    (tmp_path / "labels.png").write_bytes(grey)
    assert np.array_equal(read_labels(tmp_path / "labels.png"), values)


def test_colour_with_a_palette_is_its_colours(tmp_path):
    (tmp_path / "rgb.png").write_bytes(palette(COLOURS["colours"], transparency=1))
    assert read_colour(tmp_path / "rgb.png")[0].tolist() == [[0, 0, 0], [128, 0, 0], [128, 0, 0], [0, 128, 0]]


def test_jpeg_is_no_label_map(tmp_path):
    Image.fromarray(np.kron(INDICES, np.ones((9, 9), np.uint8)) * 60).save(tmp_path / "labels.jpg")
    for read in (read_labels, read_mask):
        with pytest.raises(FormatError, match=r"labels\.jpg: JPEG changes labels"):
            read(tmp_path / "labels.jpg")

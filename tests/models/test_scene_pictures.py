"""Pictures of random scenes: what is written is whole and repeatable, and depth, normals and flags fit the geometry."""

from pathlib import Path

import make_scenes
import numpy as np
import pytest
from scenes.camera import Camera
from scenes.light import Lighting
from scenes.materials import Materials, Table
from scenes.parts import Parts
from scenes.picture import BASELINE, FARTHEST, Picture, photographed
from scenes.shapes import box
from scenes.world import World

SIZE = (64, 48)
INTRINSICS = (60.0, 60.0, 31.5, 23.5)
RADIANCE = np.ones(3)


def arguments(out: Path, **options: int) -> list[str]:
    chosen = [text for name, value in options.items() for text in (f"--{name}", str(value))]
    return ["--out", str(out), "--size", "64x48", "--seed", "3", *chosen]


def seen(parts: Parts, materials: Materials) -> Picture:
    """Picture from the origin, straight ahead: camera axes right, down, ahead; world axes right, up, ahead."""
    camera = Camera(np.zeros(3), np.diag([1.0, -1.0, 1.0]), INTRINSICS)
    lighting = Lighting([], RADIANCE, RADIANCE, RADIANCE)
    return photographed(World(parts, Table(materials.rows)), lighting, camera, SIZE, np.random.default_rng(0))


@pytest.fixture
def materials():
    return Materials(np.random.default_rng(5))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("scenes")
    make_scenes.main(arguments(out, count=4))
    return out


def test_files_keep_the_contract(folder):
    names = sorted(path.name for path in folder.iterdir())
    assert names == [f"{number:06d}.npz" for number in range(4)]
    for name in names:
        made = np.load(folder / name)
        kinds = {key: (made[key].dtype.name, made[key].shape) for key in made.files}
        plane = SIZE[::-1]
        assert kinds == {
            "rgb": ("uint8", (*plane, 3)), "exact": ("float32", plane), "measured": ("float32", plane),
            "normals": ("float16", (*plane, 3)), "part": ("int32", plane), "object": ("int32", plane),
            "jump": ("uint8", plane), "crease": ("uint8", plane), "K": ("float32", (4,)),
        }  # fmt: skip
        assert 12 < made["rgb"].mean() < 243
        assert np.isfinite(made["exact"]).mean() > 0.5
        assert np.nanmax(made["exact"]) < FARTHEST
        assert set(np.unique(made["jump"])) | set(np.unique(made["crease"])) <= {0, 1}
        assert made["jump"].any()


def test_picture_depends_on_its_number_alone(folder, tmp_path):
    kept = tmp_path / "000002.npz"
    kept.write_bytes(b"left as it is")
    make_scenes.main(arguments(tmp_path, start=2, count=2))
    assert kept.read_bytes() == b"left as it is"
    assert (tmp_path / "000003.npz").read_bytes() == (folder / "000003.npz").read_bytes()
    other = [np.load(folder / f"{number:06d}.npz")["exact"] for number in (0, 1)]
    assert not np.array_equal(*other, equal_nan=True)


def test_normals_are_those_of_the_depth(folder):
    """Neighbours on one flat surface lie in the plane that their normal says, in camera coordinates."""
    for number in range(4):
        made = np.load(folder / f"{number:06d}.npz")
        exact, part, normals = made["exact"], made["part"], made["normals"].astype(float)
        fx, fy, cx, cy = made["K"]
        rows, columns = np.indices(exact.shape)
        rays = np.stack([(columns - cx) / fx, (rows - cy) / fy, np.ones(exact.shape)], axis=-1)
        points = exact[..., None] * rays
        assert (np.einsum("hwi,hwi->hw", normals, rays)[np.isfinite(exact)] < 0.01).all()
        flat = (part[:, :-1] == part[:, 1:]) & (np.abs(normals[:, :-1] - normals[:, 1:]).max(axis=-1) == 0)
        flat &= np.isfinite(exact[:, :-1])
        off = np.einsum("hwi,hwi->hw", points[:, 1:] - points[:, :-1], normals[:, :-1])
        assert flat.sum() > 200
        assert np.median(np.abs(off[flat]) / exact[:, :-1][flat]) < 1e-3
        assert (np.abs(off[flat]) < 0.02 * exact[:, :-1][flat]).mean() > 0.97


def test_a_part_belongs_to_one_object(folder):
    several = 0
    for number in range(4):
        made = np.load(folder / f"{number:06d}.npz")
        pairs = np.unique(np.stack([made["part"].ravel(), made["object"].ravel()]), axis=1)
        assert len(np.unique(pairs[0])) == pairs.shape[1]
        assert np.array_equal(made["part"] == -1, made["object"] == -1)
        several += pairs.shape[1] - len(np.unique(pairs[1]))
    assert several > 20


def test_glass_is_seen_and_what_is_behind_it_is_known(materials):
    pane = box((0.4, 0.4, 0.01)).moved(z=1.0)
    wall = box((9, 9, 0.1)).moved(z=2.05)
    picture = seen([(wall, materials.wall()), (pane, materials.glass())], materials)
    glass = picture.flags["transparent"]
    assert glass[24, 32]
    assert picture.exact[24, 32] == pytest.approx(0.995, abs=1e-4)
    np.testing.assert_allclose(picture.behind[glass], 2.0, atol=1e-4)
    assert np.isnan(picture.behind[~glass]).all()
    np.testing.assert_allclose(picture.exact[~glass], 2.0, atol=1e-4)


def test_projector_on_the_right_casts_its_shadow_to_the_left(materials):
    post, wall = box((0.1, 4, 0.02)).moved(z=1.0), box((9, 9, 0.1)).moved(z=2.05)
    picture = seen([(post, materials.paint()), (wall, materials.paint())], materials)
    on_post = np.flatnonzero(picture.exact[24] < 1.5)
    unlit = np.flatnonzero(picture.unlit[24])
    assert unlit.size
    assert unlit.max() == on_post.min() - 1
    # The shadow's edges, seen from the camera, are fx * baseline * (1 / near - 1 / far) left of the post's.
    assert unlit.size == pytest.approx(60 * BASELINE * (1 / 0.99 - 1 / 2.0), abs=1.1)

"""Profiles, statistics and measures against closed forms."""

import numpy as np
import pytest

from ilf.data.camera import Camera
from ilf.errors import InputError
from ilf.evaluation.measuring import angle_between, depth_profile, measure, measurements_csv, point_in_space
from ilf.evaluation.statistics import SurfaceFit, surface_statistics

CAMERA = Camera(300.0, 310.0, 79.5, 59.5)
SHAPE = (120, 160)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
RAYS = np.stack([(COLUMNS - CAMERA.cx) / CAMERA.fx, (ROWS - CAMERA.cy) / CAMERA.fy, np.ones(SHAPE)], axis=-1)


def plane_depth(normal: tuple[float, float, float], offset: float) -> np.ndarray:
    """Depth of the plane normal . point = offset, seen by `CAMERA`."""
    return offset / (RAYS @ np.array(normal))


def sphere_depth(centre: float, radius: float) -> np.ndarray:
    """Depth of the near side of a sphere on the optical axis, NaN beside it."""
    along = RAYS @ np.array([0.0, 0.0, centre])
    square = (RAYS**2).sum(axis=-1)
    under = along**2 - square * (centre**2 - radius**2)
    return (along - np.sqrt(np.where(under > 0, under, np.nan))) / square


# profile


@pytest.mark.parametrize("end", [(150.2, 20.7), (20.7, 100.2), (5.5, 110.5), (140.0, 119.9)])
def test_a_profile_reads_the_pixels_on_its_way(end):
    depth = plane_depth((0.2, -0.3, 0.9), 2.0)
    start = (10.5, 20.5)
    profile = depth_profile(depth, start, end, CAMERA, {"twice": 2 * depth})
    x, y = profile.columns, profile.rows
    assert (x[0], y[0]) == (10, 20)
    assert (x[-1], y[-1]) == (int(end[0]), int(end[1]))
    assert (np.maximum(abs(np.diff(x)), abs(np.diff(y))) == 1).all()
    np.testing.assert_allclose(profile.depth, depth[y, x], rtol=1e-6)
    np.testing.assert_allclose(profile.others["twice"], 2 * depth[y, x], rtol=1e-6)
    assert profile.pixels[-1] == pytest.approx(np.hypot(x[-1] - x[0], y[-1] - y[0]))
    # no pixel is farther from the line than half of one
    way = np.array([x[-1] - x[0], y[-1] - y[0]]) / profile.pixels[-1]
    assert (abs((x - x[0]) * way[1] - (y - y[0]) * way[0]) <= 0.5 + 1e-9).all()


def test_the_way_along_a_plane_is_the_distance_of_its_ends_whatever_is_missing():
    depth = plane_depth((0.5, 0.0, 0.8), 1.6)
    whole = depth_profile(depth, (10.5, 60.5), (140.5, 60.5), CAMERA)
    ends = [point_in_space(depth, (x, 60.5), CAMERA) for x in (10.5, 140.5)]
    assert whole.metres[-1] == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=1e-6)

    depth[:, 40:90] = np.nan
    holed = depth_profile(depth, (10.5, 60.5), (140.5, 60.5), CAMERA)
    assert np.isnan(holed.depth[30:80]).all()
    assert holed.metres[-1] == pytest.approx(whole.metres[-1], rel=1e-6)
    assert (np.diff(holed.metres) > 0).all()

    depth[:, :30] = depth[:, 130:] = np.nan
    cut = depth_profile(depth, (10.5, 60.5), (140.5, 60.5), CAMERA).metres
    assert np.flatnonzero(np.isfinite(cut))[[0, -1]].tolist() == [20, 119]
    assert cut[20] == 0.0


def test_a_profile_keeps_to_the_image():
    depth = np.full((5, 8), 2.0)
    profile = depth_profile(depth, (-10.0, 2.5), (30.0, 2.5))
    assert profile.columns.tolist() == list(range(8))
    assert profile.metres is None
    with pytest.raises(InputError, match="Draw it across"):
        depth_profile(depth, (-9.0, -9.0), (-2.0, 30.0))
    with pytest.raises(InputError, match="'ground_truth'"):
        depth_profile(depth, (0.0, 0.0), (5.0, 0.0), others={"ground_truth": np.zeros((4, 8))})


def test_a_profile_as_table():
    depth = np.array([[2.0, 0.0, 2.5]])
    profile = depth_profile(depth, (0.5, 0.5), (2.5, 0.5), others={"result": np.array([[2.0, 2.25, 2.5]])})
    assert profile.to_csv().splitlines() == [
        "x,y,distance_px,depth_m,result",
        "0,0,0.0,2.0,2.0",
        "1,0,1.0,,2.25",
        "2,0,2.0,2.5,2.5",
    ]


# statistics


def test_statistics_of_a_noisy_plane_with_holes_and_outliers():
    noise, random = 0.004, np.random.default_rng(1)
    normal = np.array([0.3, -0.5, 0.8])
    normal /= np.linalg.norm(normal)
    depth = plane_depth(tuple(normal), 2.0)
    depth += random.normal(0, noise, SHAPE) * RAYS[..., 2]
    depth[random.random(SHAPE) < 0.05] += 0.7
    depth[20:50, 30:60] = np.nan
    found = surface_statistics(depth, intrinsics=CAMERA)
    assert found.missing_share == pytest.approx(900 / depth.size)
    assert found.mean == pytest.approx(np.nanmean(depth))
    assert found.deviation == pytest.approx(np.nanstd(depth))
    assert found.noise == pytest.approx(noise, rel=0.25)
    np.testing.assert_allclose(found.plane.normal, -normal, atol=2e-3)
    assert found.plane.tilt == pytest.approx(np.degrees(np.arccos(normal[2])), abs=0.2)
    # noise along the ray counts by its part along the normal
    assert found.plane.rms == pytest.approx(noise * normal[2], rel=0.1)
    assert found.plane.outliers == pytest.approx(0.05, abs=0.01)


def test_a_sphere_is_a_quadric_and_no_plane():
    depth = sphere_depth(2.0, 0.6)
    cap = np.hypot(ROWS - 60, COLUMNS - 80) < 25
    for camera in (CAMERA, None):
        found = surface_statistics(depth, cap, camera)
        # over a circle of radius a, a cap's height is r^2 / 2 R: the deviation from its mean is a^2 / (2 R sqrt(12))
        radius = 25 / 300 * 1.4
        assert found.plane.rms == pytest.approx(radius**2 / (2 * 0.6 * np.sqrt(12)), rel=0.1)
        assert found.quadric.rms < 0.01 * found.plane.rms
        assert found.reason == ""
    assert found.plane.normal is None
    assert np.isnan(found.plane.tilt)


@pytest.mark.parametrize(
    ("box", "reason", "has_plane"),
    [
        ((slice(0, 3), slice(0, 3)), "at least 12 pixels", False),
        ((slice(0, 2), slice(0, 90)), "too narrow a strip for a plane", False),
        ((slice(0, 3), slice(0, 90)), "too narrow a strip for a quadric", True),
        ((slice(0, 4), slice(0, 5)), "A quadric needs at least 24", True),
        ((slice(40, 60), slice(40, 60)), "None of the pixels has depth", False),
    ],
)
def test_why_there_is_no_surface(box, reason, has_plane):
    depth, mask = plane_depth((0.0, 0.0, 1.0), 2.0), np.zeros(SHAPE, bool)
    depth[40:60, 40:60] = np.nan
    mask[box] = True
    found = surface_statistics(depth, mask, CAMERA)
    assert reason in found.reason
    assert (found.plane is not None) is has_plane
    assert found.quadric is None


def test_a_long_thin_strip_far_away_is_well_conditioned():
    """The quadric's terms differ by six orders of size there."""
    depth = plane_depth((0.1, 0.05, 1.0), 40.0)
    mask = np.zeros(SHAPE, bool)
    mask[50:55] = True
    found = surface_statistics(depth, mask, CAMERA)
    assert found.plane.rms < 1e-5
    assert found.quadric.rms < 1e-5
    assert found.plane.outliers == 0.0


# measures


def test_measures_on_a_wall():
    depth = np.full(SHAPE, 3.0)
    across, down = 3.0 * 30 / 300, 3.0 * 61 / 310
    level, steep = (measure(depth, ((10.5, 20.5), end), CAMERA) for end in ((40.5, 20.5), (10.5, 81.5)))
    assert (level.distance, level.height) == pytest.approx((across, 0.0))
    assert (steep.distance, steep.height) == pytest.approx((down, -down))


def test_a_point_that_lost_its_depth_says_so_by_nan():
    depth = np.full(SHAPE, 3.0)
    depth[20, 40] = np.nan
    found = measure(depth, ((10.5, 20.5), (40.5, 20.5)), CAMERA)
    assert np.isnan([found.distance, found.height]).all()
    with pytest.raises(InputError, match="no depth at x 40, y 20"):
        point_in_space(depth, (40.5, 20.5), CAMERA)
    with pytest.raises(InputError, match="intrinsics"):
        point_in_space(depth, (1.0, 1.0), None)
    with pytest.raises(InputError, match="outside the image"):
        point_in_space(depth, (-0.1, 1.0), CAMERA)


def test_the_angle_of_two_blocks():
    floor, wall = plane_depth((0.0, 1.0, 0.2), 1.0), plane_depth((0.0, 0.0, 1.0), 2.5)
    lower, upper = ROWS > 80, ROWS < 40
    planes = [surface_statistics(depth, mask, CAMERA).plane for depth, mask in ((floor, lower), (wall, upper))]
    assert angle_between(planes[0], planes[1]) == pytest.approx(np.degrees(np.arctan2(1.0, 0.2)), abs=1e-3)
    assert angle_between(planes[0], planes[0]) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(InputError, match="intrinsics"):
        angle_between(planes[0], SurfaceFit(0.0, 0.0, None, float("nan")))


def test_measures_as_table():
    line = (0.5, 0.5), (3.5, 0.5)
    depth = np.full((4, 4), 2.0)
    depth[3] = np.nan
    lost = (0.5, 0.5), (0.5, 3.5)
    camera = Camera(100.0, 100.0, 0.0, 0.0)
    table = measurements_csv([line, lost], [measure(depth, one, camera) for one in (line, lost)]).splitlines()
    assert table[0].startswith("measurement,x1,y1,x_m1")
    assert table[1] == "1,0,0,0.00000,0.00000,2.00000,3,0,0.06000,0.00000,2.00000,0.06000,0.00000"
    assert table[2] == "2,0,0,0.00000,0.00000,2.00000,0,3,,,,,"

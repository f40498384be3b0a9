"""What the paper's text leaves open: readings, claims, the search and what is said about it."""

import itertools
import math

import numpy as np
import pytest

from ilf import preset
from ilf.errors import Cancelled
from ilf.lab.experiments import interpretations as claims
from ilf.lab.experiments import unknowns
from ilf.lab.experiments.experiment import Settings
from ilf.lab.experiments.files import write_result
from ilf.lab.experiments.interpretations import EVALUATED, PAPER_PRS, PRESET, UNKNOWNS, Errors, Interpretation, to_text
from ilf.lab.experiments.registry import EXPERIMENTS, run_experiment
from ilf.lab.experiments.report import write_report
from ilf.lab.experiments.surfaces import run_case
from ilf.lab.experiments.unknowns import compare_unknowns, interpretations_of

START_OF_TEXT = Interpretation("1 / shortest", 0.5, 15.0, "taken off", 2.0, "weighted")


@pytest.fixture
def tiny(monkeypatch):
    """Quick runs of two readings on grids of a few pixels."""
    monkeypatch.setattr(unknowns, "_QUICK_EVERY", 30)
    few = {name: (getattr(PRESET, name),) for name in UNKNOWNS} | {"start": ("mean", "1 / shortest")}
    monkeypatch.setattr(unknowns, "_QUICK_UNKNOWNS", few)
    monkeypatch.setattr(unknowns, "_CURVE_RADII", (0.1, 0.4))
    monkeypatch.setattr(claims, "_CENTIMETRES", (10, 40))


def timeless(tried):
    row, cylinders, spheres = tried
    return {name: value for name, value in row.items() if name != "seconds"}, cylinders, spheres


def test_the_preset_is_one_of_the_readings():
    assert PRESET.parameters((54, 96), 1) == preset("paper", mode="fill+denoise")
    assert PRESET in interpretations_of(UNKNOWNS)
    wide = START_OF_TEXT.parameters((54, 96), 5)
    assert wide.staged_start == pytest.approx(96 / 54), "in basebands, 1 / longest length"
    assert wide.centred
    assert wide.shortest_wavelength == 3, "of every fifth pixel"


def test_every_combination_is_tried_but_for_padding():
    readings = interpretations_of(UNKNOWNS)
    assert len(set(readings)) == len(readings)
    usual = [reading for reading in readings if reading.padding == PRESET.padding]
    assert len(usual) == math.prod(len(values) for name, values in UNKNOWNS.items() if name != "padding")
    others = [reading for reading in readings if reading.padding != PRESET.padding]
    assert {(reading.step, reading.wavelength_px) for reading in others} == {(PRESET.step, PRESET.wavelength_px)}
    assert {reading.start for reading in others} == set(UNKNOWNS["start"])


def test_as_much_of_a_cylinder_is_seen_as_is_said():
    for pixels, axis in itertools.product(claims.PIXELS, ("upright", "lying")):
        whole, part = (claims.cylinder(pixels, axis, seen, 0.2, 5) for seen in (1.0, 0.5))
        assert np.ptp(whole.depth) == pytest.approx(0.2, rel=1e-3), "to the rim"
        assert np.ptp(part.depth) == pytest.approx(0.2 * (1 - math.sqrt(0.75)), rel=0.01)
        height, width = whole.size
        assert height / width == pytest.approx(whole.shape[0] / whole.shape[1]), "pixels are square"
    ball = claims.sphere(2.0, 1)
    assert (ball.shape, ball.size) == ((540, 960), (1.2, 2.6))


def test_the_largest_radius_with_the_printed_prs_is_found():
    # falls through 10.28 mm at 12.3 cm, rises through it at 33.3 cm
    assert claims.radius_of_fig_4(lambda radius: PAPER_PRS * (1 + abs(radius - 0.228) - 0.105) ** 9) == 0.33
    assert claims.radius_of_fig_4(lambda radius: 100 * radius) == pytest.approx(0.1)
    assert claims.radius_of_fig_4(lambda radius: 50 + 10 * radius) == 0.05, "the nearest, where none gives it"


def test_orders_are_beaten_one_after_the_other(monkeypatch):
    def errors(value):
        return Errors(value, 2 * value, 0.0, value)

    def fitted(case, order, deviations):
        better = order == 3 and case.rate == 0.2 and deviations < math.inf
        return errors(0.5 if better else 10.0 / order)

    monkeypatch.setattr(claims, "fitted", fitted)
    monkeypatch.setattr(claims, "filtered", lambda reading, case, every: errors(3.0))
    surface = claims.cylinder("480 x 480", "lying", 1.0, 0.2, 10)
    beaten = claims.orders_beaten(PRESET, surface, 0.0065, 10, 0)
    assert beaten == {"block": 2, "hole": 2, "PRS": 2, "block, plain fit": 3, "hole, plain fit": 3}


def test_errors_are_those_of_the_other_experiments():
    case = claims.case_of(claims.cylinder("480 x 480", "lying", 0.6, 0.5, 15), 0.0065, 0.4, 15, 3)
    assert case.noise == pytest.approx(0.0065 / 15)
    paper, peer = run_case(case, ["paper", "polynomial-2"])
    rescaled = Interpretation(**{**vars(PRESET), "wavelength_px": 15.0 * 15})  # as the preset has it on this grid
    mine = claims.filtered(rescaled, case, 15)
    assert (mine.acc, mine.prs, mine.whole, mine.hole) == pytest.approx(
        tuple(paper[name] for name in ("acc_mm", "prs_mm", "rmse_mm", "hole_rmse_mm"))
    )
    assert claims.fitted(case, 2, 2.5).whole == pytest.approx(peer["rmse_mm"])


def test_a_reading_is_as_good_as_its_best_cylinder_and_sphere():
    def cylinder(prs, order, fig4):
        return {
            "pixels": "480 x 480", "axis": "lying", "seen": 1.0, "radius_m": 0.1, "acc_mm": 0.0, "prs_mm": prs,
            "fig4": fig4, **dict.fromkeys(EVALUATED, order),
        }  # fmt: skip

    def sphere(order, with_noise):
        return {
            "sphere_radius_m": 2.0, **dict.fromkeys(EVALUATED, order),
            **{f"{evaluated}, noise": with_noise for evaluated in EVALUATED},
        }  # fmt: skip

    spheres = [sphere(4, 1), sphere(3, 3)]
    best = unknowns._best_of([cylinder(10.3, 1, True), cylinder(10.1, 2, True), cylinder(None, 4, None)], spheres)
    assert (best["prs_mm"], best["fig6_order"], best["fig6_apart_order"]) == (10.1, 2, 4)
    assert (best["fig5_order"], best["fig5_noise_order"]) == (3, 3)
    assert (best["order, block"], best["order apart, block"]) == (2, 3)
    none = unknowns._best_of([cylinder(50.0, 0, False), cylinder(None, 4, None)], spheres)
    assert not none["fig4"]
    assert none["order, block"] == none["order apart, block"] == 0, "without Fig. 4 not all come out"


def test_the_search_runs_is_written_and_reported(tiny, tmp_path):
    seen = []
    result = run_experiment("unknowns", Settings(quick=True), seen.append)
    assert [progress.done for progress in seen] == list(range(seen[0].total + 1))
    assert [row["start"] for row in result.rows] == ["mean", "1 / shortest"]
    assert [row["preset"] for row in result.rows] == [True, False]
    assert sum(row["closest"] for row in result.rows) == 1
    assert {row["figure"] for row in result.tables["curves"]} == {"Fig. 4", "Fig. 6", "Fig. 5, 0 mm", "Fig. 5, 65 mm"}
    write_result(result, EXPERIMENTS["unknowns"], tmp_path)
    page, text = write_report(tmp_path, markdown_file=tmp_path / "experiments.md")
    assert page.read_text().count("data:image/png;base64,") == 3
    assert "of 2 interpretations" in text.read_text()


def test_the_same_seed_gives_the_same_numbers(tiny):
    first, again, other = (timeless(unknowns.try_interpretation(PRESET, True, seed)) for seed in (3, 3, 4))
    assert first == again != other


def test_the_search_can_be_stopped(tiny):
    def stop(progress):
        if progress.done == 1:
            raise Cancelled("stopped")

    with pytest.raises(Cancelled):
        run_experiment("unknowns", Settings(quick=True), stop)


def test_what_is_said_follows_from_the_rows():
    def row(reading, fig6, fig5):
        order = min(fig6, fig5)
        return {
            **vars(reading), "preset": reading == PRESET, "pixels": "480 x 480", "axis": "lying", "seen": 1.0,
            "radius_m": 0.1, "acc_mm": -3.0, "prs_mm": 10.3, "fig4": True, "fig6_order": fig6,
            "fig6_apart_order": fig6, "fig5_order": fig5, "fig5_noise_order": fig5,
            **{f"order{kind}, {evaluated}": order for kind in ("", " apart") for evaluated in EVALUATED},
        }  # fmt: skip

    apart = [row(PRESET, 3, 1), row(START_OF_TEXT, 1, 3)]
    fourth, sixth, _, fifth, _, together, _ = compare_unknowns(apart)
    assert fourth.ours == "2 of 2 interpretations"
    assert sixth.ours == "against order 2: 1, 3: 1, 4: 0 of 2 interpretations"
    assert "All that win have start mean and mean depth left in." in sixth.text
    assert "wins against orders up to 3" in sixth.text
    assert "start 1 / shortest and mean depth taken off" in fifth.text
    assert "The preset paper does not win." in fifth.text
    assert together.text.startswith("No interpretation reproduces all of them.")
    both = compare_unknowns([row(PRESET, 3, 1), row(START_OF_TEXT, 2, 3)])[5]
    assert "against order 2: 1, 3: 0" in both.ours
    assert "No interpretation" not in both.text


def test_readings_are_named_as_a_reader_knows_them():
    assert to_text(vars(PRESET)).startswith(
        "start mean, step [basebands] 0.5, shortest wave [px] 15, mean depth left in"
    )

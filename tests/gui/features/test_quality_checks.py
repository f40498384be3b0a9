"""The order in which flagged places are shown."""

from gui.features.quality import Review
from ilf.evaluation.quality.places import Place


def place(x: float, score: float, label: int = 1, kind: str = "jump") -> Place:
    box = slice(0, 20), slice(int(x) - 10, int(x) + 10)
    return Place(kind, box, (label,), (x, 10.0), score, f"At {x:g}")


FIRST, SECOND, THIRD = place(100, 9), place(200, 6), place(300, 3)


def reviewed(*places: Place) -> Review:
    review = Review()
    review.take(places)
    return review


def test_round_and_round_both_ways():
    review = reviewed(FIRST, SECOND, THIRD)
    assert (review.present, review.number) == (None, 0)
    assert [review.step(1) for _ in range(4)] == [FIRST, SECOND, THIRD, FIRST]
    assert review.step(-1) is THIRD
    assert review.number == 3
    assert reviewed(FIRST, SECOND, THIRD).step(-1) is THIRD


def test_nothing_to_go_to():
    review = reviewed()
    assert review.step(1) is review.step(-1) is None


def test_after_a_mended_place_comes_the_next_worse_one():
    review = reviewed(FIRST, SECOND, THIRD)
    review.step(1)
    review.step(1)
    assert review.take([FIRST, THIRD])
    assert review.present is None
    assert review.step(1) is THIRD
    review.step(-1)
    assert review.take([THIRD])
    assert review.step(-1) is THIRD


def test_what_an_edit_has_only_moved_is_still_looked_at():
    review = reviewed(FIRST, SECOND)
    review.step(1)
    moved = place(108, 2)
    assert not review.take([SECOND, moved])
    assert (review.present, review.number) == (moved, 2)


def test_another_kind_or_block_at_the_same_spot_is_another_place():
    review = reviewed(FIRST)
    review.step(1)
    assert review.take([place(100, 9, label=2)])
    review = reviewed(FIRST)
    review.step(1)
    assert review.take([place(100, 9, kind="island")])

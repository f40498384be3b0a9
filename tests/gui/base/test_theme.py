"""Both themes can be read by everybody: contrasts as WCAG 2 asks, and colours that colour-blind people tell apart."""

from collections import Counter
from collections.abc import Callable
from itertools import combinations
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QGroupBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QMenu,
    QMenuBar,
    QProgressBar,
    QPushButton,
    QRadioButton,
    QSlider,
    QTabBar,
    QToolButton,
    QTreeWidget,
    QVBoxLayout,
    QWidget,
)

from gui.base import theme
from gui.widgets.basics import Message

TEXT, LINE = 4.5, 3.0
APART = 20.0
"""Distance in CIELAB of colours that are told apart without a legend beside them."""

# severe protanopia and deuteranopia, on linear RGB (Machado, Oliveira and Fernandes 2009)
SEEN_BY = {
    "everybody": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}


def _linear(colour: QColor) -> np.ndarray:
    sent = np.array([colour.redF(), colour.greenF(), colour.blueF()])
    return np.where(sent <= 0.04045, sent / 12.92, ((sent + 0.055) / 1.055) ** 2.4)


def lab(colour: QColor, eye: str) -> np.ndarray:
    seen = np.clip(SEEN_BY[eye] @ _linear(colour), 0, 1)
    return cv2.cvtColor(np.float32([[seen]]), cv2.COLOR_LRGB2Lab)[0, 0]


def _apart(one: QColor, other, eye: str) -> float:
    return float(np.linalg.norm(lab(one, eye) - lab(other, eye)))


def contrast(one: QColor, other: QColor) -> float:
    """Return the contrast ratio of two colours, 1 to 21, as WCAG 2 defines it."""
    darker, brighter = sorted(_linear(colour) @ (0.2126, 0.7152, 0.0722) for colour in (one, other))
    return (brighter + 0.05) / (darker + 0.05)


pytestmark = pytest.mark.usefixtures("any_theme")


@pytest.fixture(params=["light", "dark"])
def palette(request, qapp):
    theme.apply_theme(qapp, request.param)
    return qapp.palette()


def test_texts_and_lines_stand_out_on_every_ground(palette):
    colours = theme.colours(palette)
    grounds = [palette.color(role) for role in (palette.ColorRole.Window, palette.ColorRole.Base)]
    grounds.append(palette.color(palette.ColorRole.Button))
    texts = (colours.text, colours.muted, colours.accent, colours.warning, colours.error, colours.good)
    for ground in grounds:
        assert min(contrast(text, ground) for text in texts) >= TEXT
        assert contrast(colours.grid, ground) >= LINE
    for line in colours.series:  # they also name the curves in their colours
        assert contrast(line, colours.background) >= TEXT
    chosen = palette.highlightedText().color(), palette.highlight().color()
    assert contrast(*chosen) >= TEXT


@pytest.mark.parametrize("kind", [QLineEdit, QDoubleSpinBox, QComboBox])
def test_input_fields_have_a_frame(palette, kind, qtbot):
    field = kind()
    qtbot.addWidget(field)
    field.resize(120, field.sizeHint().height())
    frame = field.grab().toImage().pixelColor(0, field.height() // 2)
    assert contrast(frame, palette.color(palette.ColorRole.Window)) >= LINE


def test_the_handle_and_the_groove_of_a_slider_are_seen(palette, qtbot):
    slider = QSlider(Qt.Orientation.Horizontal)
    slider.setFixedWidth(200)
    image, window = _drawn(_inside(slider), qtbot), palette.window().color()
    for columns in (range(20), range(150, 160)):  # the handle, and the groove beside it
        found = [image.pixelColor(x, y) for x in columns for y in range(image.height())]
        assert max(contrast(colour, window) for colour in found) >= LINE


@pytest.mark.parametrize("kind", [QCheckBox, QRadioButton])
@pytest.mark.parametrize("is_on", [False, True])
def test_what_is_ticked_has_a_frame(palette, kind, is_on, qtbot):
    image = _drawn(_inside(kind("on", checked=is_on)), qtbot)
    left = [image.pixelColor(x, image.height() // 2) for x in range(2)]
    assert max(contrast(colour, palette.window().color()) for colour in left) >= LINE


@pytest.mark.parametrize("eye", SEEN_BY)
def test_good_and_worse_and_the_lines_of_a_plot_are_told_apart(palette, eye):
    colours = theme.colours(palette)
    for worse in (colours.warning, colours.error):
        assert _apart(colours.good, worse, eye) >= APART
    for one, other in combinations(colours.series, 2):
        assert _apart(one, other, eye) >= APART


def _tree() -> QTreeWidget:
    tree = QTreeWidget()
    tree.setHeaderLabels(["Missing"])
    tree.setFixedHeight(tree.header().sizeHint().height())
    return tree


def _chosen_row() -> QListWidget:
    rows = QListWidget()
    rows.addItem("room")
    rows.setCurrentRow(0)
    rows.setFixedSize(80, rows.sizeHintForRow(0) + 2)
    return rows


def _message(tone: str) -> Callable[[], Message]:
    def make() -> Message:
        message = Message()
        message.show_message("14 blocks", tone)
        return message

    return make


def _combo() -> QComboBox:
    combo = QComboBox()
    combo.addItem("fill")
    return combo


def _inside(widget: QWidget) -> QWidget:
    """A widget on the ground of a window."""
    window = QWidget()
    column = QVBoxLayout(window)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(widget)
    return window


def _menu() -> QMenu:
    menu = QMenu()
    menu.addAction("Open")
    return menu


WIDGETS: dict[str, Callable[[], QWidget]] = {
    "label": lambda: QLabel("Smoothness"),
    "check box": lambda: _inside(QCheckBox("Learned correction")),
    "button": lambda: QPushButton("Export"),
    "tool button": lambda: QToolButton(text="Run"),
    "list of choices": _combo,
    "number": QDoubleSpinBox,
    "group": lambda: QGroupBox("Depth"),
    "placeholder": lambda: QLineEdit(placeholderText="Name"),
    "header": _tree,
    "chosen row": _chosen_row,
    "progress": lambda: QProgressBar(value=100),
    "menu": _menu,
    **{f"message, {tone}": _message(tone) for tone in ("muted", "warning", "error", "good")},
}


def _drawn(widget: QWidget, qtbot) -> QImage:
    qtbot.addWidget(widget)
    widget.adjustSize()
    widget.show()
    return widget.grab().toImage()


@pytest.mark.parametrize("make", WIDGETS.values(), ids=WIDGETS.keys())
def test_drawn_texts_stand_out(palette, qtbot, make):
    image = _drawn(make(), qtbot)
    places = ((x, y) for x in range(2, image.width() - 2) for y in range(2, image.height() - 2))
    shares = Counter(image.pixel(*place) for place in places)
    ground = QColor(shares.most_common(1)[0][0])
    assert max(contrast(QColor(colour), ground) for colour in shares) >= TEXT


@pytest.mark.parametrize("kind", [QTabBar, QMenuBar])
def test_tabs_and_menus_take_a_theme_chosen_while_they_are_shown(qapp, qtbot, kind):
    def bar():
        made = kind()
        add = made.addTab if kind is QTabBar else made.addAction
        first, _ = add("One"), add("Two")
        if kind is QMenuBar:
            made.setActiveAction(first)
        return made

    theme.apply_theme(qapp, "light")
    shown = bar()
    _drawn(shown, qtbot)
    theme.apply_theme(qapp, "dark")
    qapp.processEvents()
    assert shown.grab().toImage() == _drawn(bar(), qtbot)


class _Bar(QTabBar):
    """Tabs that count how often they are drawn."""

    drawn = 0

    def paintEvent(self, event):
        self.drawn += 1
        super().paintEvent(event)


def test_tabs_that_were_drawn_before_they_have_the_theme_are_drawn_again(qapp, qtbot, monkeypatch):
    later = []
    monkeypatch.setattr(theme, "QTimer", Mock(singleShot=lambda _, __, call: later.append(call)))
    theme.apply_theme(qapp, "light")
    bar = _Bar()
    bar.addTab("One")
    _drawn(bar, qtbot)
    theme.apply_theme(qapp, "dark")
    qtbot.wait(100)  # drawn with the colours of before
    before = bar.drawn
    later[-1]()
    qtbot.waitUntil(lambda: bar.drawn > before)

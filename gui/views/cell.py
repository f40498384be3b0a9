"""A cell of the linked views: it shows one content, which the user selects in the menu of its title."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QMenu, QVBoxLayout, QWidget

from ..widgets.basics import lay_out
from .image_view import STYLES, ImageView
from .layers import CONTENTS, Layer, Legend, checked, content_of, lacking, striped, title_of, uses
from .title_strip import TitleStrip
from .view_data import DIFFERENCE, FLICKERS, RUNS, SIDES, ViewData, capital, difference_of, short_title

EventHandler = Callable[[ImageView, QEvent], bool]


class Cell(QWidget):
    """View of one content: title strip with the colour bar over an image view. Draws only while it is visible.

    Signals
    -------
    chosen(str)
        The user selected another content.
    """

    chosen = Signal(str)

    def __init__(self, content: str, on_event: EventHandler, data: ViewData) -> None:
        super().__init__()
        self.content = content
        """Name of the content; `concrete` is the content that it currently resolves to."""
        self.concrete = ""
        self.strip = TitleStrip()
        self.view = ImageView(on_event)
        self.bar = self.strip.bar
        lay_out(QVBoxLayout(self), self.strip, self.view, spacing=0, stretched=self.view)
        self._data = data
        self._needs_draw = False
        self._menu = QMenu("Content of the view", self, toolTipsVisible=True)
        self.strip.menuRequested.connect(self.open_menu)
        self.strip.doubleClicked.connect(self._menu.close)
        self.follow()

    @property
    def uses(self) -> frozenset[str]:
        """Parts of the data that the content depends on."""
        return uses(self.concrete, self._data)

    @property
    def range_kind(self) -> str:
        """Kind of the content's colour range; "" for none."""
        return content_of(self.concrete).range_kind

    def set_content(self, content: str) -> None:
        """Show another content.

        Raises
        ------
        ValueError
            If the content does not exist.
        """
        self.content = checked(content)
        self.follow()

    def follow(self) -> None:
        """Change to another layer if the content resolves to another concrete content."""
        concrete = self._data.concrete(self.content)
        if concrete == self.concrete:
            return
        self.concrete = concrete
        self.strip.set_title(title_of(concrete, self._data))
        self._show(Layer())
        self.view.is_of_frame = concrete != "spectrum"
        self.view.has_lines = concrete != "extraction"  # its blocks differ from those of the frame
        self.view.fills.set_visible(concrete == "colour")
        self.draw_again()

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y) and mark its value on the colour bar; None hides both."""
        self.view.show_cursor(pixel)
        self._show_value()

    def _show_value(self) -> None:
        pixel = None if self._needs_draw or self.bar.isHidden() else self.view.pointed
        self.bar.set_value(None if pixel is None else self.view.value_at(*pixel))

    def open_menu(self) -> None:
        """Open the content menu, filled anew, since runs change."""
        _fill(self._menu, self._data, self.content, self.chosen.emit)
        self._menu.popup(self.strip.menu_position())

    def draw_again(self) -> None:
        """Draw what has changed, at once or when the cell becomes visible."""
        self._needs_draw = not self.isVisible()
        if not self._needs_draw:
            data, run = self._data, self._data.run(self.concrete)
            self.strip.set_title(title_of(self.concrete, data), None if run is None else run.colour)
            self.view.stripe(striped(data, self.concrete))
            self._show(content_of(self.concrete).find(data, self.concrete))
            self._show_value()

    def _show(self, layer: Layer) -> None:
        self.strip.set_text(layer.text)
        self.strip.set_legend([*_stripe_legend(self.view.striped), *layer.legend])
        self.bar.show_layer(layer, content_of(self.concrete).unit)
        self.view.setAccessibleName(self.strip.title)
        self.view.draw(layer)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._needs_draw:
            self.draw_again()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # at once, not in a later Qt event: what the view shows depends on its size
        strip = self.strip.height()
        self.strip.setGeometry(0, 0, self.width(), strip)
        self.view.setGeometry(0, strip, self.width(), max(self.height() - strip, 0))


def _stripe_legend(names: Iterable[str]) -> Legend:
    """Return what stripes over the picture mean."""
    patterns = {1: Qt.BrushStyle.FDiagPattern, -1: Qt.BrushStyle.BDiagPattern}
    styles = [(name, STYLES[name]) for name in names]
    return [(QBrush(QColor(style.legend), patterns[style.lean]), name) for name, style in styles]


_GROUPS = (
    ("colour", "depth-in", "result", *RUNS, "ground_truth", "guide"),
    (DIFFERENCE, "error", "expected-error", *FLICKERS),
)
"""The first contents of the menu; all others follow, but depths that are only compared with."""
_SIDE_TEXTS = {"a": "Side A", "b": "Side B"}


def _fill(menu: QMenu, data: ViewData, chosen: str, choose: Callable[[str], object]) -> None:
    """Fill a menu with the available contents, with one of them checked; `choose` is given the one that is taken."""
    menu.clear()
    for below in menu.findChildren(QMenu, options=Qt.FindChildOption.FindDirectChildrenOnly):
        below.deleteLater()

    def add(menu: QMenu, content: str, text: str) -> None:
        action = menu.addAction(text.replace("&", "&&"))
        action.setCheckable(True)
        action.setChecked(content == chosen)
        why_off = lacking(content, data)
        action.setEnabled(not why_off)
        action.triggered.connect(lambda: choose(content))
        action.setToolTip(why_off)

    def add_differences() -> None:
        depths, differences = data.comparable(), menu.addMenu("Difference of")
        for first in depths:
            others = differences.addMenu(capital(short_title(first, data.names)).replace("&", "&&"))
            for second in depths:
                if second != first:
                    add(others, difference_of(first, second), f"less {short_title(second, data.names)}")

    others = [name for name, one in CONTENTS.items() if one.title and not any(name in group for group in _GROUPS)]
    for group in (*_GROUPS, others):
        for name in group:
            if name not in RUNS or name in data.names:
                shown = data.concrete(name) if name == DIFFERENCE else name
                add(menu, name, content_of(shown).title or title_of(shown, data))
            if name == DIFFERENCE:
                add_differences()
        menu.addSeparator()
    if chosen == "extraction":
        stages = menu.addMenu("Stage of the extraction")
        stages.setToolTipsVisible(True)
        stages.addActions(data.stage_actions)
    for side, depth in zip(SIDES, data.sides, strict=True):
        add(menu, side, f"{_SIDE_TEXTS[side]} of the comparison ({short_title(depth, data.names)})")

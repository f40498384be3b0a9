"""Light and dark palettes, colours of plots and overlays, and icons."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from PySide6.QtCore import QRect, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QIcon, QIconEngine, QPainter, QPalette, QPixmap
from PySide6.QtWidgets import QApplication, QMenuBar, QTabBar, QToolTip

THEMES = ("system", "light", "dark")
_CHOICE = "ilf_theme"

_LIGHT = {
    "window": "#f3f4f6",
    "base": "#ffffff",
    "text": "#1c1f24",
    "muted": "#5c636e",
    "border": "#c3c8d0",
    "accent": "#0b5fac",
    "on_accent": "#ffffff",
    "button": "#fbfbfc",
    "warning": "#8f5a00",
    "error": "#c02a1e",
    "good": "#00796b",
}
_DARK = {
    "window": "#23262b",
    "base": "#1a1c20",
    "text": "#e6e8eb",
    "muted": "#a0a8b3",
    "border": "#444a53",
    "accent": "#4aa3f0",
    "on_accent": "#0e1116",
    "button": "#2e3238",
    "warning": "#e0a030",
    "error": "#ff8a75",
    "good": "#3ecfc0",
}
"""Texts have a contrast of 4.5 at least on window, base and button; what is good differs from warnings and errors for
colour-blind people, too."""

_LINE = "#7f8792"
"""Axes, ticks and frames of boxes to tick, sliders and input fields: a contrast of 3 at least in both themes."""

_FRAMED = {
    "QLineEdit": 140,
    "QAbstractSpinBox": 140,
    "QComboBox": 140,
    "QSlider": 140,
    "QRadioButton": 140,
    "QCheckBox": 126,
}
"""Widgets on the window's ground, of which Qt draws frames alone in the window's colour -> how many per cent darker."""

_Role = QPalette.ColorRole
_ROLES = {
    "window": (_Role.Window, _Role.AlternateBase),
    "base": (_Role.Base, _Role.ToolTipBase),
    "text": (_Role.WindowText, _Role.Text, _Role.ButtonText, _Role.ToolTipText),
    "muted": (_Role.PlaceholderText,),
    "border": (_Role.Mid, _Role.Dark),
    "accent": (_Role.Highlight, _Role.Link, _Role.LinkVisited, _Role.Accent),
    "on_accent": (_Role.HighlightedText,),
    "button": (_Role.Button, _Role.Light, _Role.Midlight),
}
"""Colour of the theme -> what it is used for by Qt."""

_SERIES = {False: ("#1060e8", "#a04000", "#0a6058", "#700a80"), True: ("#4a90f2", "#fb7a35", "#1fb888", "#f3b8f4")}
"""Whether dark -> the colours of lines in one plot."""


_STYLE_SHEET = """
    QToolTip { padding: 3px; }
    QMenuBar::item { padding: 7px 5px 4px; background: transparent; }
    QMenuBar::item:selected { background: palette(highlight); color: palette(highlighted-text); }
    QToolBar { border: none; spacing: 2px; padding: 2px; }
    QDockWidget::title { padding: 3px 8px; }
    QMainWindow::separator { background: rgba(128, 128, 128, 80); width: 1px; height: 1px; }
    QStatusBar::item { border: none; }
    QTabBar::tab:!selected { color: palette(placeholder-text); }
    QDialogButtonBox { dialogbuttonbox-buttons-have-icons: 0; }
    QCheckBox::indicator:unchecked, QGroupBox::indicator:unchecked,
    QListView::indicator:unchecked, QTableView::indicator:unchecked, QTreeView::indicator:unchecked {
        border: 1px solid LINE; border-radius: 2px; background: transparent;
    }
    QHeaderView::section { background: transparent; border: none; padding: 3px 5px; }
""".replace("LINE", _LINE)
"""For both themes, without their colours: another style sheet makes Qt polish every widget again, which takes long."""


@dataclass(frozen=True)
class Colours:
    """Colours beyond the palette's, for plots, overlays and states."""

    background: QColor
    panel: QColor
    text: QColor
    muted: QColor
    border: QColor
    grid: QColor
    accent: QColor
    warning: QColor
    error: QColor
    good: QColor
    series: tuple[QColor, ...]

    @property
    def is_dark(self) -> bool:
        """Whether the theme is dark."""
        return self.panel.lightness() < 128


def apply_theme(app: QApplication, name: str = "system") -> None:
    """Set the application's palette to "light", "dark" or, for "system", that of the system."""
    if name not in THEMES:
        raise ValueError(f"theme must be one of {', '.join(THEMES)}, not {name!r}")
    if app.styleSheet() != _STYLE_SHEET:
        app.setAttribute(Qt.ApplicationAttribute.AA_UseStyleSheetPropagationInWidgetStyles)
        app.setStyle("Fusion")
        app.setStyleSheet(_STYLE_SHEET)
    app.setProperty(_CHOICE, name)
    of_system = app.styleHints().colorScheme() == Qt.ColorScheme.Dark
    tones = _DARK if name == "dark" or (name == "system" and of_system) else _LIGHT
    palette = _palette(tones)
    app.setPalette(palette)
    QToolTip.setPalette(palette)
    palette.setColor(QPalette.ColorRole.ButtonText, QColor(tones["muted"]))
    app.setPalette(palette, "QHeaderView")  # type: ignore[arg-type]
    for kind, darker in _FRAMED.items():
        framed = QPalette()
        framed.setColor(QPalette.ColorRole.Window, QColor(_LINE).lighter(darker))
        app.setPalette(framed, kind)  # type: ignore[arg-type]
    QTimer.singleShot(0, app, _renew_bars)


def _renew_bars() -> None:
    """Let tabs and menu bars take the palette's colours in the style sheet anew, once they have the palette."""
    for widget in QApplication.allWidgets():
        if isinstance(widget, (QMenuBar, QTabBar)):
            widget.style().unpolish(widget)
            widget.style().polish(widget)
            widget.update()  # it may have been painted in between


def follow_system(app: QApplication) -> None:
    """Change between light and dark with the system while the theme is "system"."""
    app.styleHints().colorSchemeChanged.connect(
        lambda _: apply_theme(app, "system") if app.property(_CHOICE) == "system" else None
    )


def is_dark(palette: QPalette) -> bool:
    """Return whether a palette is dark."""
    return colours(palette).is_dark


def colours(palette: QPalette) -> Colours:
    """Return the colours for a palette."""
    used = palette.base(), palette.window(), palette.windowText(), palette.highlight()
    return _colours(*(brush.color().rgb() for brush in used))


@cache
def _colours(base: int, window: int, text: int, accent: int) -> Colours:
    dark = QColor(window).lightness() < 128
    tones = _DARK if dark else _LIGHT
    return Colours(
        background=QColor(base),
        panel=QColor(window),
        text=QColor(text),
        grid=QColor(_LINE),
        accent=QColor(accent),
        **{name: QColor(tones[name]) for name in ("muted", "border", "warning", "error", "good")},
        series=tuple(QColor(name) for name in _SERIES[dark]),
    )


def blend(first: QColor, second: QColor, share: float) -> QColor:
    """Blend two colours; `share` is the weight of the second."""
    pairs = (first.redF(), second.redF()), (first.greenF(), second.greenF()), (first.blueF(), second.blueF())
    return QColor.fromRgbF(*(a + (b - a) * share for a, b in pairs))


def faded(colour: QColor, opacity: int) -> QColor:
    """Return a colour with an opacity, of 255."""
    return QColor(colour.red(), colour.green(), colour.blue(), opacity)


@cache
def icon(name: str, tone: str = "text") -> QIcon:
    """Return an icon of the Phosphor set ("ph.play") in a colour of `Colours`, by its name: of the theme in which it is
    painted."""
    return QIcon(_IconEngine(name, tone))


class _IconEngine(QIconEngine):
    """Paints an icon in the colours that the application has then."""

    def __init__(self, name: str, tone: str) -> None:
        super().__init__()
        self._name, self._tone = name, tone

    def _now(self) -> QIcon:
        used = colours(QApplication.palette())
        return _icon(self._name, getattr(used, self._tone).rgba(), used.accent.rgba(), used.muted.rgba())

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        self._now().paint(painter, rect, mode=mode, state=state)

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        return self._now().pixmap(size, 1.0, mode, state)


@cache
def _icon(name: str, colour: int, active: int, muted: int) -> QIcon:
    import qtawesome

    faint = faded(QColor(muted), 110)
    own = QColor(colour)
    return qtawesome.icon(name, color=own, color_active=QColor(active), color_selected=own, color_disabled=faint)


def _palette(tones: dict[str, str]) -> QPalette:
    palette = QPalette()
    for tone, roles in _ROLES.items():
        for role in roles:
            palette.setColor(role, QColor(tones[tone]))
    for role in (*_ROLES["text"][:3], *_ROLES["muted"]):
        palette.setColor(QPalette.ColorGroup.Disabled, role, faded(QColor(tones["muted"]), 140))
    return palette

"""Light and dark palettes, colours of plots and overlays, and icons."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QIcon, QPalette
from PySide6.QtWidgets import QApplication, QToolTip

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
        muted=QColor(tones["muted"]),
        border=QColor(tones["border"]),
        grid=QColor(_LINE),
        accent=QColor(accent),
        warning=QColor(tones["warning"]),
        error=QColor(tones["error"]),
        good=QColor(tones["good"]),
        series=tuple(QColor(name) for name in _SERIES[dark]),
    )


def blend(first: QColor, second: QColor, share: float) -> QColor:
    """Blend two colours; `share` is the weight of the second."""
    pairs = (first.redF(), second.redF()), (first.greenF(), second.greenF()), (first.blueF(), second.blueF())
    return QColor.fromRgbF(*(a + (b - a) * share for a, b in pairs))


def icon(name: str, palette: QPalette, tone: str = "text") -> QIcon:
    """Return an icon of the Phosphor set ("ph.play") in a colour of `Colours`, by its name."""
    used = colours(palette)
    return _icon(name, getattr(used, tone).rgba(), used.accent.rgba(), used.muted.rgba())


@cache
def _icon(name: str, colour: int, active: int, muted: int) -> QIcon:
    import qtawesome

    faint = QColor(muted)
    faint.setAlpha(110)
    return qtawesome.icon(name, color=QColor(colour), color_active=QColor(active), color_disabled=faint)


def _palette(tones: dict[str, str]) -> QPalette:
    palette = QPalette()
    roles = {
        QPalette.ColorRole.Window: "window",
        QPalette.ColorRole.WindowText: "text",
        QPalette.ColorRole.Base: "base",
        QPalette.ColorRole.AlternateBase: "window",
        QPalette.ColorRole.Text: "text",
        QPalette.ColorRole.Button: "button",
        QPalette.ColorRole.ButtonText: "text",
        QPalette.ColorRole.ToolTipBase: "base",
        QPalette.ColorRole.ToolTipText: "text",
        QPalette.ColorRole.PlaceholderText: "muted",
        QPalette.ColorRole.Highlight: "accent",
        QPalette.ColorRole.HighlightedText: "on_accent",
        QPalette.ColorRole.Link: "accent",
        QPalette.ColorRole.LinkVisited: "accent",
        QPalette.ColorRole.Light: "button",
        QPalette.ColorRole.Midlight: "button",
        QPalette.ColorRole.Mid: "border",
        QPalette.ColorRole.Dark: "border",
        QPalette.ColorRole.Accent: "accent",
    }
    for role, tone in roles.items():
        palette.setColor(role, QColor(tones[tone]))
    faint = QColor(tones["muted"])
    faint.setAlpha(140)
    for role in (
        QPalette.ColorRole.WindowText,
        QPalette.ColorRole.Text,
        QPalette.ColorRole.ButtonText,
        QPalette.ColorRole.PlaceholderText,
    ):
        palette.setColor(QPalette.ColorGroup.Disabled, role, faint)
    return palette

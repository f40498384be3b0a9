"""Light and dark palettes, colours of plots and overlays, and icons."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QIcon, QPalette
from PySide6.QtWidgets import QApplication, QToolTip

THEMES = ("system", "light", "dark")
_CHOICE = "ilf_theme"

_LIGHT = {
    "window": "#f3f4f6",
    "base": "#ffffff",
    "text": "#1c1f24",
    "muted": "#68707c",
    "border": "#d3d7de",
    "accent": "#0f6fc6",
    "button": "#fbfbfc",
}
_DARK = {
    "window": "#23262b",
    "base": "#1a1c20",
    "text": "#e6e8eb",
    "muted": "#98a0ab",
    "border": "#3b4048",
    "accent": "#4aa3f0",
    "button": "#2e3238",
}


_STYLE_SHEET = """
    QToolTip { padding: 3px; }
    QToolBar { border: none; spacing: 2px; padding: 2px; }
    QDockWidget::title { padding: 3px 8px; }
    QMainWindow::separator { background: rgba(128, 128, 128, 80); width: 1px; height: 1px; }
    QStatusBar::item { border: none; }
    QCheckBox::indicator:unchecked, QGroupBox::indicator:unchecked,
    QListView::indicator:unchecked, QTableView::indicator:unchecked, QTreeView::indicator:unchecked {
        border: 1px solid #7f8792; border-radius: 2px; background: transparent;
    }
    QHeaderView::section { background: transparent; border: none; padding: 3px 5px; }
"""
"""For both themes, without their colours: another style sheet makes Qt polish every widget again, which takes long."""


@dataclass(frozen=True)
class Colours:
    """Colours beyond the palette's, for plots, overlays and states."""

    background: QColor
    panel: QColor
    text: QColor
    muted: QColor
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
    tones = _DARK if name == "dark" or (name == "system" and _system_is_dark(app)) else _LIGHT
    palette = _palette(tones)
    app.setPalette(palette)
    QToolTip.setPalette(palette)
    palette.setColor(QPalette.ColorRole.ButtonText, QColor(tones["muted"]))
    app.setPalette(palette, "QHeaderView")  # type: ignore[arg-type]


def follow_system(app: QApplication) -> None:
    """Change between light and dark with the system while the theme is "system"."""
    app.styleHints().colorSchemeChanged.connect(
        lambda _: apply_theme(app, "system") if app.property(_CHOICE) == "system" else None
    )


def is_dark(palette: QPalette) -> bool:
    """Return whether a palette is dark."""
    return palette.window().color().lightness() < 128


def colours(palette: QPalette) -> Colours:
    """Return the colours for a palette."""
    dark = is_dark(palette)
    text = palette.windowText().color()
    series = ("#4aa3f0", "#f0a04a", "#5ac88c", "#d86ad0") if dark else ("#0f6fc6", "#c8641b", "#1d8a52", "#a23a9a")
    return Colours(
        background=palette.base().color(),
        panel=palette.window().color(),
        text=text,
        muted=QColor(_DARK["muted"] if dark else _LIGHT["muted"]),
        grid=QColor(_DARK["border"] if dark else _LIGHT["border"]),
        accent=palette.highlight().color(),
        warning=QColor("#e0a030" if dark else "#a86a00"),
        error=QColor("#f06a5f" if dark else "#c02a1e"),
        good=QColor("#5ac88c" if dark else "#1d8a52"),
        series=tuple(QColor(name) for name in series),
    )


def icon(name: str, palette: QPalette) -> QIcon:
    """Return an icon of the Phosphor set ("ph.play") in the palette's colours."""
    import qtawesome

    muted = QColor((_DARK if is_dark(palette) else _LIGHT)["muted"])
    muted.setAlpha(110)
    return qtawesome.icon(
        name,
        color=palette.windowText().color(),
        color_active=palette.highlight().color(),
        color_disabled=muted,
    )


def _system_is_dark(app: QApplication) -> bool:
    return app.styleHints().colorScheme() == Qt.ColorScheme.Dark


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
        QPalette.ColorRole.Link: "accent",
        QPalette.ColorRole.Mid: "border",
    }
    for role, tone in roles.items():
        palette.setColor(role, QColor(tones[tone]))
    palette.setColor(QPalette.ColorRole.HighlightedText, QColor("#ffffff"))
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

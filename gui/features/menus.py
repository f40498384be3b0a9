"""Menus, tool bar and tool column: the place of every command."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QSettings, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QMenu, QMenuBar, QToolBar, QToolButton, QWidget

from ilf.drawing.blocks import STAGES

from ..base import theme
from ..base.commands import Actions, plain
from ..tools.kinds import KINDS
from ..tools.options_row import BY_HAND, OptionsRow
from ..views.colours import DEPTH_MAP, DEPTH_MAPS
from ..views.layouts import CELLS, LAYOUT_TEXTS
from ..views.linked_views import LinkedViews
from ..views.view_menus import SidesMenu
from ..widgets.basics import add_choices

BLOCK_MENU = (
    "run_selected zoom_block | rename_block merge_blocks delete_blocks lock_blocks hide_blocks mark_checked | "
    "grow_blocks shrink_blocks smooth_blocks clean_up | new_block fit"
)
PLAY_MENU = (
    "play_frames | speed_quarter speed_half speed_normal speed_double speed_fourfold speed_fastest | "
    "play_loop play_completed play_recorded"
)
_TOOLS = " ".join(f"tool_{kind.name}" for kind in KINDS if not kind.inspects)
_INSPECT = (
    f"{' '.join(f'tool_{kind.name}' for kind in KINDS if kind.inspects)} | remove_marks | save_profile "
    "save_profile_picture | copy_statistics | copy_measurements save_measurements delete_measurements"
)
_GOING = "next_frame previous_frame next_untouched mark_done note_frame"
_MENUS = {
    "&File": "open open_sample play_live_menu recent_menu | new_project save_project "
    "save_project_as show_project | load_ground_truth remove_ground_truth | load_guide guide_by_network remove_guide | "
    "use_neighbours remove_neighbours | load_blocks "
    "save_blocks | export export_all batch "
    "report save_picture | close_frame quit",
    "&Edit": f"undo redo | {_TOOLS} | next_tool previous_tool | brush_smaller brush_larger "
    f"similar_only to_no_block | {BY_HAND} | cancel_stroke",
    "&Blocks": "extract | propagate_next propagate_previous propagate_through propagation_menu | "
    "new_block rename_block delete_blocks merge_blocks lock_blocks hide_blocks | "
    "grow_blocks shrink_blocks smooth_blocks clean_up | zoom_block select_all",
    "I&nspect": _INSPECT,
    "Revie&w": "next_check previous_check apply_remedy ignore_check mark_checked | suggest_invalid",
    "&Run": "run run_selected run_all | pause step cancel | live | reset_own copy_own | "
    "share_parameters keep_own_parameters reset_to_shared separate_parameters | extrapolate clear_results | "
    "hold_out_test sweep | show_runs compare_runs accept_run restore_run export_runs clear_runs",
    "&View": f"fit one_to_one zoom_block show_before_edit | {_GOING} | full_screen layout_menu play_menu | panels_menu "
    "toggle_panels film_strip only_icons | view_content reset_contents compare_menu | contours_only block_names "
    "show_missing shuffle_colours turn_cloud cloud_beside cloud_raw cloud_selected_only | view_set_menu stage_menu "
    "depth_colours_menu show_range fit_range lock_range theme_menu",
    "&Help": "palette shortcuts | about",
}

_MAP_KEY = "depth_colours/map"

_ICONS = QSize(20, 20)
_SMALL = 0.88
"""Size of the names under the icons of the tools, as a share of the text's."""


class _Bar(QToolBar):
    """A bar whose buttons have names, unless the user wants only icons."""

    named = Qt.ToolButtonStyle.ToolButtonTextBesideIcon

    def __init__(self, name: str, only_icons: QAction, window: QWidget) -> None:
        super().__init__(name, window)
        self.setObjectName(name)
        self.setMovable(False)
        self.setIconSize(_ICONS)
        only_icons.toggled.connect(self._show_names)
        self._show_names(only_icons.isChecked())

    def _show_names(self, only_icons: bool) -> None:
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly if only_icons else self.named)


class ToolColumn(_Bar):
    """The tools that correct blocks, at the left side of the window, with narrow names of one or two lines."""

    named = Qt.ToolButtonStyle.ToolButtonTextUnderIcon

    def __init__(self, actions: Actions, window: QWidget) -> None:
        super().__init__("Tool column", actions["only_icons"], window)
        self.setOrientation(Qt.Orientation.Vertical)
        actions.fill(self, _TOOLS)
        small = self.font()
        small.setPointSizeF(_SMALL * small.pointSizeF())
        for button in self.findChildren(QToolButton):
            button.setFont(small)
        for action in self.actions():
            action.setIconText(plain(action.text()).replace(" ", "\n", 1))


class ToolBar(_Bar):
    """Frequent commands and the options of the tool; what needs a selected block or a run is there only then."""

    def __init__(self, actions: Actions, options: OptionsRow, window: QWidget) -> None:
        super().__init__("Tools", actions["only_icons"], window)
        actions.fill(self, "open save_project export | run live | undo redo")
        self._undo = [self.widgetForAction(actions[name]) for name in ("undo", "redo")]
        self._options = self.addWidget(options)
        for name in ("pause", "step", "cancel", "run_selected", "merge_blocks", "delete_blocks"):
            # not with every edit that is followed live
            self._add_while_usable(actions[name], actions["pause" if name in ("step", "cancel") else name])
        self.toolButtonStyleChanged.connect(self._leave_out_steps)
        self._leave_out_steps()

    def _leave_out_steps(self) -> None:
        """Leave out the texts of undo and redo, which change with each step."""
        for button in self._undo:
            assert isinstance(button, QToolButton)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)

    def show_options(self, on: bool) -> None:
        """Show or hide the tool's options; they are shown where the tool can be used."""
        self._options.setVisible(on)

    def _add_while_usable(self, action: QAction, decides: QAction) -> None:
        """Add a button that is there only while an action can be used."""
        button = QToolButton(autoRaise=True)
        button.setDefaultAction(action)
        button.setToolButtonStyle(self.toolButtonStyle())
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.toolButtonStyleChanged.connect(button.setToolButtonStyle)
        place = self.addWidget(button)
        place.setVisible(decides.isEnabled())
        decides.enabledChanged.connect(place.setVisible)


def draw_extensions(window: QWidget) -> None:
    """Draw the arrows of bars that have no room for all; those of Qt are black in both themes."""
    for name in ("qt_menubar_ext_button", "qt_toolbar_ext_button"):
        for button in window.findChildren(QToolButton, name):
            side = "down" if isinstance(button.parent(), ToolColumn) else "right"
            button.setIcon(theme.icon(f"ph.caret-double-{side}"))


def fill_menu_bar(bar: QMenuBar, actions: Actions, views: LinkedViews, toggles: Iterable[QAction]) -> None:
    """Create all menus; `toggles` show and hide the docks."""
    views.data.stage_actions = [actions[f"stage_{name}"] for name in STAGES]
    for action, text in zip(views.data.stage_actions, STAGES.values(), strict=True):
        action.setIconText(text)
    panels = actions.menu("&Panels", bar)
    panels.addActions(list(toggles))
    compare = actions.menu("Comp&are two depths", bar, "compare_two swipe blink | swap_sides")
    for side in (0, 1):
        compare.addMenu(SidesMenu(views, side, compare))
    below = {
        "panels": panels,
        "compare": compare,
        "view_set": _layout_menu(views, bar),
        "play_live": actions.menu("Play li&ve", bar, "play_recording play_folder play_camera"),
        "play": actions.menu("Play the frames", bar, PLAY_MENU),
        "propagation": actions.menu("Pr&opagation method", bar, "propagate_auto propagate_copied propagate_flow"),
        "stage": actions.menu("Stage of the extraction", bar, " ".join(f"stage_{name}" for name in STAGES)),
        "depth_colours": _depth_map_menu(views, bar),
        "theme": _theme_menu(bar),
    }
    for name, menu in below.items():
        actions.adopt(f"{name}_menu", menu.menuAction(), "ph.play-circle" if name == "play_live" else "")
    for title, names in _MENUS.items():
        bar.addMenu(actions.menu(title, bar, names))


def _layout_menu(views: LinkedViews, parent: QWidget) -> QMenu:
    menu = QMenu("View set", parent)
    actions = add_choices(menu, LAYOUT_TEXTS, views.sheet.layout_name, views.sheet.set_layout)
    menu.insertSeparator(actions[next(iter(CELLS))])
    views.sheet.layoutChanged.connect(lambda name: actions[name].setChecked(True))
    return menu


def _depth_map_menu(views: LinkedViews, parent: QWidget) -> QMenu:
    """The colour maps of depth; the choice is remembered."""
    menu = QMenu("Depth colours", parent)

    def choose(name: str) -> None:
        views.ranges.set_depth_map(name)
        QSettings().setValue(_MAP_KEY, name)

    actions = add_choices(menu, {name: name.capitalize() for name in DEPTH_MAPS}, DEPTH_MAP, choose)
    views.rangeChanged.connect(lambda: actions[views.data.depth_map].setChecked(True))
    stored = str(QSettings().value(_MAP_KEY, DEPTH_MAP))
    if stored in DEPTH_MAPS:
        views.ranges.set_depth_map(stored)
    return menu


def _theme_menu(parent: QWidget) -> QMenu:
    """The themes; the choice is remembered."""
    menu = QMenu("&Theme", parent)
    texts = {name: name.capitalize() for name in theme.THEMES}
    add_choices(menu, texts, str(QSettings().value("theme", "system")), _set_theme)
    return menu


def _set_theme(name: str) -> None:
    QSettings().setValue("theme", name)
    app = QApplication.instance()
    if isinstance(app, QApplication):
        theme.apply_theme(app, name)

"""Every command of the window: name, text, shortcut, icon and hint, declared once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from PySide6.QtGui import QAction, QActionGroup, QKeySequence, QUndoGroup
from PySide6.QtWidgets import QWidget

from . import theme
from .commands import WHY_NOT, Command

# The commands of the 3D view.

_CLOUD_COMMANDS: tuple[Command, ...] = (
    Command(
        "cloud_beside",
        "&3D beside the images",
        "ph.columns",
        "Ctrl+Shift+B",
        "Show the point cloud beside the images instead of in its own tab",
        checkable=True,
    ),
    Command(
        "cloud_raw",
        "3D: ra&w depth",
        "ph.eye",
        "",
        "Show the point cloud before completion; holding X in the 3D view does the same",
        checkable=True,
    ),
    Command(
        "cloud_selected_only",
        "3D: selected blocks onl&y",
        "ph.selection",
        "",
        "Show only the selected blocks in 3D",
        checkable=True,
    ),
)


COMMANDS = (
    Command("open", "&Open frame…", "ph.folder-open", "Ctrl+O", "Open a colour and a depth file, or a frame folder"),
    Command(
        "open_sample", "Open &sample", "ph.house", "Ctrl+Shift+O", "Open the bundled sample frame, a synthetic room"
    ),
    Command(
        "open_run", "Open &run…", "ph.clock-counter-clockwise", "", "Open a run.json: its frame, blocks and parameters"
    ),
    Command(
        "load_blocks",
        "Load &blocks…",
        "ph.squares-four",
        "",
        "Replace the blocks with those from a label map, a labelme or COCO file, or a folder of masks",
    ),
    Command(
        "save_blocks",
        "Save b&locks…",
        "",
        "",
        "Write the blocks and their names as label map (PNG), COCO or labelme file",
    ),
    Command(
        "export", "&Export…", "ph.export", "Ctrl+E", "Write completed depth, blocks, curves, point cloud and run.json"
    ),
    Command("save_picture", "Save &picture of the window…", "ph.camera", "", "Save a screenshot of the window as PNG"),
    Command("close_frame", "&Close frame", "ph.x", "Ctrl+W", "Close the current frame"),
    Command("quit", "&Quit", "ph.sign-out", "Ctrl+Q"),
    Command(
        "extract",
        "E&xtract blocks",
        "ph.polygon",
        "Ctrl+B",
        "Extract the blocks again; locked blocks and hand-made blocks stay",
    ),
    Command(
        "new_block", "&New block", "ph.selection-plus", "Ctrl+N", "Start a new block with the brush or the outline tool"
    ),
    Command("delete_blocks", "&Delete blocks", "ph.trash", "Ctrl+Del", "Delete the selected blocks"),
    Command("merge_blocks", "&Merge blocks", "ph.intersect", "Ctrl+M", "Merge the selected blocks into one"),
    Command(
        "lock_blocks", "&Lock or unlock", "ph.lock", "Ctrl+L", "Protect the selected blocks from edits, or unlock them"
    ),
    Command("zoom_block", "&Zoom to block", "ph.magnifying-glass-plus", "Ctrl+J", "Zoom to the selected block"),
    Command("select_all", "Select &all blocks", "ph.selection-all", "Ctrl+A", "Select all blocks"),
    Command(
        "run",
        "&Run",
        "ph.play",
        "F5",
        "Complete all blocks that have no up-to-date result",
    ),
    Command("run_all", "Run &all blocks", "", "Ctrl+F5", "Complete all blocks, also those with an up-to-date result"),
    Command(
        "run_selected",
        "Run selecte&d blocks",
        "ph.play-circle",
        "Shift+F5",
        "Complete the selected blocks only",
    ),
    Command("pause", "&Pause", "ph.pause", "F6", "Pause the run, or resume it", checkable=True),
    Command("step", "&Step", "ph.skip-forward", "F7", "Run one iteration, then pause"),
    Command("cancel", "&Cancel run", "ph.stop", "Shift+F6", "Cancel the run; completed blocks keep their results"),
    Command(
        "live",
        "&Live",
        "ph.lightning",
        "Ctrl+Shift+L",
        "Complete blocks again after each edit, and the selected block after each change of a filter parameter",
        checkable=True,
    ),
    Command(
        "extrapolate",
        "&Extrapolate the rest",
        "ph.question",
        "",
        "Extrapolate depth where no block could be completed, for programs that need depth everywhere; "
        "these pixels are marked as extrapolated",
    ),
    Command(
        "reset_own",
        "Reset &own parameters",
        "ph.eraser",
        "",
        "Reset the selected blocks to the common parameters",
    ),
    Command(
        "copy_own",
        "Copy own para&meters",
        "ph.copy",
        "",
        "Copy the own parameters of the first selected block to the other selected blocks",
    ),
    Command(
        "share_parameters",
        "Use parameters for all &frames",
        "ph.share-network",
        "",
        "Use this frame's filter parameters for all frames in the list, now and after each change",
    ),
    Command(
        "keep_own_parameters",
        "Use parameters for this frame o&nly",
        "ph.push-pin",
        "",
        "Give this frame its own filter parameters: changes for all frames do not affect them",
    ),
    Command(
        "reset_to_shared",
        "Reset to s&hared parameters",
        "ph.arrow-u-up-left",
        "",
        "Reset this frame to the filter parameters that all frames share",
    ),
    Command(
        "separate_parameters",
        "Separa&te parameters for each frame",
        "",
        "",
        "Set filter parameters for each frame separately; all frames keep their current parameters",
    ),
    Command("clear_results", "C&lear results", "ph.backspace", "", "Delete the completed depth of this frame"),
    Command(
        "show_before_edit",
        "Show state &before the last edit",
        "ph.eye",
        "",
        "Show blocks and depth before the last edit; holding B does the same",
        checkable=True,
    ),
    Command("tool_select", "&Select", "ph.cursor", "Ctrl+1", "Select blocks", group="tool"),
    Command(
        "tool_border",
        "&Border",
        "ph.pencil-line",
        "Ctrl+2",
        "Redraw a border between two blocks; the blocks on both sides follow",
        group="tool",
    ),
    Command(
        "tool_outline",
        "&Outline",
        "ph.scribble-loop",
        "Ctrl+3",
        "Outline pixels to add to the selected block, or to make a new block",
        group="tool",
    ),
    Command("tool_split", "Sp&lit", "ph.scissors", "Ctrl+4", "Cut a block along a line", group="tool"),
    Command("tool_paint", "&Paint", "ph.paint-brush", "Ctrl+5", "Add pixels to the selected block", group="tool"),
    Command("tool_erase", "&Erase", "ph.eraser", "Ctrl+6", "Remove pixels from the selected block", group="tool"),
    Command(
        "tool_give",
        "&Give",
        "ph.puzzle-piece",
        "Ctrl+7",
        "Give pieces of other blocks to the selected block",
        group="tool",
    ),
    Command(
        "tool_mark_invalid",
        "Mark depth &invalid",
        "ph.shield-slash",
        "Ctrl+8",
        "Mark measured depth as invalid, for example behind glass: it counts as missing",
        group="tool",
    ),
    Command(
        "tool_profile",
        "&Profile line",
        "ph.chart-line-up",
        "Ctrl+I",
        "Draw a line across the image and plot the depth along it",
        group="tool",
    ),
    Command(
        "tool_rectangle",
        "&Rectangle",
        "ph.bounding-box",
        "Ctrl+R",
        "Draw a rectangle for statistics and errors",
        group="tool",
    ),
    Command(
        "tool_measure",
        "&Measure",
        "ph.ruler",
        "Ctrl+D",
        "Measure distances, heights and angles between points",
        group="tool",
    ),
    Command(
        "cancel_stroke", "Ca&ncel stroke", "", "Esc", "Cancel the stroke or line in progress, or clear the selection"
    ),
    Command("brush_smaller", "Smaller brush", "", "["),
    Command("brush_larger", "Larger brush", "", "]"),
    Command(
        "similar_only",
        "&Similar only",
        "ph.eyedropper",
        "Ctrl+Shift+K",
        "Limit strokes to pixels of similar colour and depth, up to strong edges",
        checkable=True,
    ),
    Command(
        "to_no_block",
        "To &no block",
        "ph.selection-slash",
        "Ctrl+Shift+E",
        "Assign erased pixels to no block instead of the best-fitting neighbour",
        checkable=True,
    ),
    Command(
        "clean_up",
        "&Clean up",
        "ph.sparkle",
        "Ctrl+K",
        "Assign islands, slivers and holes of a few pixels to the blocks around them",
    ),
    Command("grow_blocks", "&Grow", "ph.arrows-out-simple", "Ctrl++", "Grow the selected blocks"),
    Command("shrink_blocks", "S&hrink", "ph.arrows-in-simple", "Ctrl+-", "Shrink the selected blocks"),
    Command("smooth_blocks", "S&mooth", "ph.waves", "Ctrl+Alt+S", "Smooth the outlines of the selected blocks"),
    Command("hide_blocks", "Show or h&ide", "ph.eye", "Ctrl+H", "Show or hide the selected blocks over the image"),
    Command(
        "next_check",
        "Next &quality check",
        "ph.crosshair",
        "F8",
        "Go to the next place where blocks or filled depth look wrong, largest error first",
    ),
    Command("previous_check", "Pre&vious quality check", "ph.caret-left", "Shift+F8", "Go to the previous place"),
    Command("ignore_check", "&Ignore", "ph.check", "Ctrl+F8", "Ignore this place: it is not shown again"),
    Command(
        "mark_checked",
        "Ma&rk as checked",
        "ph.check",
        "Ctrl+Shift+F8",
        "Mark the selected blocks, which were propagated from another frame, as checked",
    ),
    Command(
        "suggest_invalid",
        "Su&ggest invalid depth",
        "ph.warning",
        "",
        "Find known depth that is probably wrong (flying pixels, speckles, glass), to accept or reject",
    ),
    Command("close_checks", "&Close", "ph.x", "", "End the quality check"),
    Command("mark_suggested", "Mark &invalid", "ph.check", "", "Mark the suggested depth as invalid: it is missing"),
    Command("ignore_suggested", "Reject", "ph.x", "", "Keep the suggested depth as valid"),
    Command("fit", "&Fit frame", "ph.arrows-out", "Ctrl+0", "Show the whole frame"),
    Command("one_to_one", "&One to one", "ph.frame-corners", "Ctrl+9", "Show one image pixel per screen pixel"),
    Command(
        "contours_only",
        "&Contours only",
        "ph.polygon",
        "Ctrl+Shift+C",
        "Show blocks as outlines, without fill",
        checkable=True,
    ),
    Command(
        "block_names",
        "Block &names",
        "ph.text-t",
        "Ctrl+Shift+T",
        "Show the names of the blocks over the images",
        checkable=True,
    ),
    Command(
        "show_missing",
        "&Missing depth over colour",
        "ph.selection-slash",
        "Ctrl+Shift+H",
        "Stripe the colour image where depth is missing",
        checkable=True,
    ),
    Command(
        "shuffle_colours", "&Shuffle colours", "ph.shuffle", "", "Assign other colours to the blocks, as one undo step"
    ),
    Command(
        "toggle_panels",
        "S&how or hide all panels",
        "ph.arrows-in-line-horizontal",
        "F9",
        "Hide all panels to leave the window to the images, or show them again",
    ),
    Command(
        "stage_strength",
        "Edge &strength",
        "",
        "Alt+1",
        "Show the edge strength: how much each pixel looks like a boundary",
        group="stage",
    ),
    Command(
        "stage_binarised",
        "&Binarised edges",
        "",
        "Alt+2",
        "Show the binarised edges over the colour image",
        group="stage",
    ),
    Command(
        "stage_dilated",
        "&Dilated edges",
        "",
        "Alt+3",
        "Show the dilated edges, with the added pixels marked",
        group="stage",
    ),
    Command(
        "stage_contracted",
        "&Contracted regions",
        "",
        "Alt+4",
        "Show the regions after contraction, grown back to the edges",
        group="stage",
    ),
    Command("stage_blocks", "B&locks found", "", "Alt+5", "Show the blocks that the extraction finds", group="stage"),
    Command("full_screen", "F&ull screen", "ph.corners-out", "F11", "Show the window in full screen", checkable=True),
    Command(
        "palette", "Command &palette…", "ph.magnifying-glass", "Ctrl+Shift+P", "Find a command by part of its name"
    ),
    Command("shortcuts", "&Keyboard shortcuts…", "ph.keyboard", "F1", "Show the keyboard shortcuts and change them"),
    Command("about", "&About ILF Studio", "ph.info"),
    *_CLOUD_COMMANDS,
)
_HISTORY_ICONS = {"undo": "ph.arrow-counter-clockwise", "redo": "ph.arrow-clockwise"}


class Actions:
    """The window's QActions by name: `actions["run"]`; "undo" and "redo" come from the undo history."""

    def __init__(self, window: QWidget, history: QUndoGroup) -> None:
        self._window = window
        self._icons = dict(_HISTORY_ICONS)
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        undo, redo = history.createUndoAction(window, "Undo"), history.createRedoAction(window, "Redo")
        undo.triggered.disconnect()  # during a stroke, the editor handles undo
        undo.setShortcut(QKeySequence("Ctrl+Z"))
        redo.setShortcuts([QKeySequence("Ctrl+Shift+Z"), QKeySequence("Ctrl+Y")])
        for name, action in (("undo", undo), ("redo", redo)):
            action.setObjectName(name)
            action.setProperty(WHY_NOT, f"Nothing to {name}.")
            self._actions[name] = action
        self._draw_icons(_HISTORY_ICONS)
        self.add(COMMANDS)

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def add(self, commands: Iterable[Command]) -> None:
        """Add the commands of a feature, which executes them itself."""
        icons = {}
        for command in commands:
            icons[command.name] = command.icon
            action = QAction(command.text, self._window)
            action.setObjectName(command.name)
            action.setShortcut(QKeySequence(command.shortcut))
            plain = command.text.replace("&", "")
            keys = (
                f" ({action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)})" if command.shortcut else ""
            )
            action.setToolTip(f"{command.hint or plain}{keys}")
            action.setCheckable(command.checkable or bool(command.group))
            if command.group:
                self._groups.setdefault(command.group, QActionGroup(self._window)).addAction(action)
            self._window.addAction(action)
            self._actions[command.name] = action
        self._icons |= icons
        self._draw_icons(icons)

    def draw_icons(self) -> None:
        """Redraw the icons in the colours of the window's palette."""
        self._draw_icons(self._icons)

    def _draw_icons(self, icons: Mapping[str, str]) -> None:
        palette = self._window.palette()
        for name, icon in icons.items():
            if icon:
                self[name].setIcon(theme.icon(icon, palette))

    def allow(self, why_not: str, *names: str) -> None:
        """Enable actions if `why_not` is ""; else disable them and store it: the reason and what to do first."""
        for name in names:
            self[name].setEnabled(not why_not)
            self[name].setProperty(WHY_NOT, why_not)

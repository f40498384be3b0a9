"""Every command of the window: name, text, shortcut, icon and hint, declared once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from PySide6.QtGui import QAction, QActionGroup, QKeySequence, QUndoGroup
from PySide6.QtWidgets import QWidget

from . import theme
from .commands import WHY_NOT, Command

# The commands of the 3D view.

_OF_CLOUD: tuple[Command, ...] = (
    Command(
        "cloud_beside",
        "&3D beside the images",
        "ph.columns",
        "Ctrl+Shift+B",
        "Show the point cloud beside the images instead of in a tab of its own",
        checkable=True,
    ),
    Command(
        "cloud_raw",
        "3D: ra&w depth",
        "ph.eye",
        "",
        "Show the cloud as it was before the completion; the same in 3D while X is held",
        checkable=True,
    ),
    Command(
        "cloud_chosen_only",
        "3D: chosen blocks onl&y",
        "ph.selection",
        "",
        "Show only the chosen blocks in 3D",
        checkable=True,
    ),
)


COMMANDS = (
    Command("open", "&Open frame…", "ph.folder-open", "Ctrl+O", "Open a colour and a depth file, or a frame folder"),
    Command("open_sample", "Open &sample", "ph.house", "Ctrl+Shift+O", "Open the bundled, generated room"),
    Command(
        "open_run", "Open &run…", "ph.clock-counter-clockwise", "", "Open a run.json: its frame, blocks and parameters"
    ),
    Command(
        "load_blocks",
        "Load &blocks…",
        "ph.squares-four",
        "",
        "Replace the blocks by those of a label map, labelme or COCO file, or of a folder of masks",
    ),
    Command(
        "save_blocks", "Save b&locks…", "", "", "Write the blocks as label map (PNG), COCO or labelme file, with names"
    ),
    Command("export", "&Export…", "ph.export", "Ctrl+E", "Write completed depth, blocks, curves, cloud and run.json"),
    Command("save_picture", "Save &picture of the window…", "ph.camera", "", "Save what the window shows as PNG"),
    Command("close_frame", "&Close frame", "ph.x", "Ctrl+W", "Close the present frame"),
    Command("quit", "&Quit", "ph.sign-out", "Ctrl+Q"),
    Command(
        "extract",
        "E&xtract blocks",
        "ph.polygon",
        "Ctrl+B",
        "Extract blocks again; locked ones stay, and those made by hand",
    ),
    Command(
        "new_block", "&New block", "ph.selection-plus", "Ctrl+N", "Start a new block, with the brush or the outline"
    ),
    Command("delete_blocks", "&Delete blocks", "ph.trash", "Ctrl+Del", "Dissolve the chosen blocks"),
    Command("merge_blocks", "&Merge blocks", "ph.intersect", "Ctrl+M", "Join the chosen blocks into one"),
    Command(
        "lock_blocks", "&Lock or unlock", "ph.lock", "Ctrl+L", "Keep the chosen blocks from being edited, or allow it"
    ),
    Command("zoom_block", "&Zoom to block", "ph.magnifying-glass-plus", "Ctrl+J", "Show the chosen block large"),
    Command("select_all", "Select &all blocks", "ph.selection-all", "Ctrl+A", "Choose every block"),
    Command(
        "run",
        "&Run what changed",
        "ph.play",
        "F5",
        "Complete the depth of all blocks that have no result as they are now",
    ),
    Command(
        "run_all", "Run &all blocks", "", "Ctrl+F5", "Complete the depth of all blocks, also where nothing changed"
    ),
    Command(
        "run_selected",
        "Run &chosen blocks",
        "ph.play-circle",
        "Shift+F5",
        "Complete the depth of the chosen blocks only",
    ),
    Command("pause", "&Pause", "ph.pause", "F6", "Hold the run, or go on", checkable=True),
    Command("step", "&Step", "ph.skip-forward", "F7", "One iteration, then hold"),
    Command("cancel", "&Cancel run", "ph.stop", "Shift+F6", "Stop; blocks that are done keep their results"),
    Command(
        "live",
        "&Live",
        "ph.lightning",
        "Ctrl+Shift+L",
        "Solve blocks anew whenever they are edited, and the chosen one whenever a value of the filter changes",
        checkable=True,
    ),
    Command(
        "guess",
        "&Guess the rest",
        "ph.question",
        "",
        "Guess the depth that no block could complete, for programs that need all of it; it is marked as guessed",
    ),
    Command(
        "reset_own",
        "&Reset own values",
        "ph.eraser",
        "",
        "Let the chosen blocks have the values of all blocks again",
    ),
    Command(
        "copy_own",
        "C&opy own values",
        "ph.copy",
        "",
        "Give the other chosen blocks the own values of the first",
    ),
    Command(
        "share_values",
        "Use values for all &frames",
        "ph.share-network",
        "",
        "Give this frame's values of the filter to all frames of the list, now and whenever they change",
    ),
    Command(
        "keep_values",
        "Values for this frame al&one",
        "ph.push-pin",
        "",
        "Let this frame's values of the filter be its own: what is set for all frames does not change them",
    ),
    Command(
        "reset_values",
        "Reset to the &values of all frames",
        "ph.arrow-u-up-left",
        "",
        "Let this frame have the values of all frames again",
    ),
    Command(
        "part_values",
        "&Each frame its own values",
        "",
        "",
        "Set values of the filter for one frame at a time; all keep those that they have now",
    ),
    Command("clear_results", "C&lear results", "ph.backspace", "", "Forget the completed depth of this frame"),
    Command(
        "look_before",
        "Look &before the last edit",
        "ph.eye",
        "",
        "Show blocks and depth as they were before the last edit; the same while B is held",
        checkable=True,
    ),
    Command("tool_select", "&Select", "ph.cursor", "Ctrl+1", "Choose blocks", group="tool"),
    Command(
        "tool_border",
        "&Border",
        "ph.pencil-line",
        "Ctrl+2",
        "Draw a border between blocks as it should be; both sides follow",
        group="tool",
    ),
    Command(
        "tool_outline",
        "&Outline",
        "ph.scribble-loop",
        "Ctrl+3",
        "Draw around what belongs to the chosen block, or is a new one",
        group="tool",
    ),
    Command("tool_split", "Sp&lit", "ph.scissors", "Ctrl+4", "Cut a block along a line", group="tool"),
    Command("tool_paint", "&Paint", "ph.paint-brush", "Ctrl+5", "Add pixels to the chosen block", group="tool"),
    Command("tool_erase", "&Erase", "ph.eraser", "Ctrl+6", "Take pixels from the chosen block", group="tool"),
    Command(
        "tool_give", "&Give", "ph.puzzle-piece", "Ctrl+7", "Give pieces of blocks to the chosen block", group="tool"
    ),
    Command(
        "tool_distrust",
        "&Distrust depth",
        "ph.shield-slash",
        "Ctrl+8",
        "Mark measured depth as wrong, as behind glass: it counts as missing",
        group="tool",
    ),
    Command(
        "tool_profile",
        "&Profile line",
        "ph.chart-line-up",
        "Ctrl+I",
        "Draw a line across the picture, and see the depth along it plotted",
        group="tool",
    ),
    Command(
        "tool_rectangle",
        "&Rectangle",
        "ph.bounding-box",
        "Ctrl+R",
        "Draw a rectangle to take statistics and errors of",
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
    Command("give_up", "Gi&ve up", "", "Esc", "Drop the stroke or line that is under way, or else choose no block"),
    Command("brush_smaller", "Smaller brush", "", "["),
    Command("brush_larger", "Larger brush", "", "]"),
    Command(
        "similar_only",
        "&Similar only",
        "ph.eyedropper",
        "Ctrl+Shift+K",
        "A stroke keeps to pixels of like colour and depth, up to strong edges",
        checkable=True,
    ),
    Command(
        "to_no_block",
        "To &no block",
        "ph.selection-slash",
        "Ctrl+Shift+E",
        "Erased pixels belong to no block, instead of the neighbour that they fit best",
        checkable=True,
    ),
    Command(
        "clean_up",
        "&Clean up",
        "ph.sparkle",
        "Ctrl+K",
        "Give islands, slivers and holes of a few pixels to the blocks where they belong",
    ),
    Command("grow_blocks", "&Grow", "ph.arrows-out-simple", "Ctrl++", "Let the chosen blocks gain a rim"),
    Command("shrink_blocks", "S&hrink", "ph.arrows-in-simple", "Ctrl+-", "Let the chosen blocks lose their rim"),
    Command("smooth_blocks", "S&mooth", "ph.waves", "Ctrl+Alt+S", "Make the outlines of the chosen blocks smooth"),
    Command("hide_blocks", "Show or h&ide", "ph.eye", "Ctrl+H", "Show the chosen blocks over the picture, or do not"),
    Command(
        "next_suspect",
        "Next s&uspicious place",
        "ph.crosshair",
        "F8",
        "Go to the next place where blocks or filled depth look wrong, the most harmful first",
    ),
    Command("previous_suspect", "Pre&vious suspicious place", "ph.caret-left", "Shift+F8", "Go back to the one before"),
    Command("leave_suspect", "&Leave it", "ph.check", "Ctrl+F8", "This place is right as it is: do not show it again"),
    Command(
        "looked_at",
        "Looked at, &right as it is",
        "ph.check",
        "Ctrl+Shift+F8",
        "The chosen blocks, which came from another frame, need no look any more",
    ),
    Command(
        "suggest_distrust",
        "Su&ggest distrusted depth",
        "ph.warning",
        "",
        "Look for known depth that is likely wrong: flying pixels, speckles, glass; you take it or leave it",
    ),
    Command("close_review", "&Close", "ph.x", "", "Look at no more suspicious places"),
    Command("take_suggested", "&Distrust them", "ph.check", "", "Let the marked depth count as missing"),
    Command("leave_suggested", "Leave them", "ph.x", "", "Trust the marked depth on"),
    Command("fit", "&Fit frame", "ph.arrows-out", "Ctrl+0", "Show the whole frame"),
    Command("one_to_one", "&One to one", "ph.frame-corners", "Ctrl+9", "One image pixel on one screen pixel"),
    Command(
        "contours_only",
        "&Contours only",
        "ph.polygon",
        "Ctrl+Shift+C",
        "Lines in the colours of the blocks, and no fill",
        checkable=True,
    ),
    Command(
        "block_names",
        "Block &names",
        "ph.text-t",
        "Ctrl+Shift+T",
        "Write the names of the blocks over the pictures",
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
    Command("shuffle_colours", "&Shuffle colours", "ph.shuffle", "", "Give the blocks other colours, as one step"),
    Command(
        "fold_panels",
        "&Fold or open all panels",
        "ph.arrows-in-line-horizontal",
        "F9",
        "All of the window for the pictures",
    ),
    Command(
        "stage_strength",
        "Edge &strength",
        "",
        "Alt+1",
        "Show how much every pixel looks like a boundary",
        group="stage",
    ),
    Command(
        "stage_binarised",
        "&Binarised edges",
        "",
        "Alt+2",
        "Show the edges that count, over the colour image",
        group="stage",
    ),
    Command(
        "stage_dilated",
        "&Dilated edges",
        "",
        "Alt+3",
        "Show the edges with what the dilation adds around them",
        group="stage",
    ),
    Command(
        "stage_contracted",
        "&Contracted regions",
        "",
        "Alt+4",
        "Show the regions that have grown back to the edges",
        group="stage",
    ),
    Command(
        "stage_blocks", "B&locks found", "", "Alt+5", "Show the blocks that the extraction would give", group="stage"
    ),
    Command(
        "full_screen", "F&ull screen", "ph.corners-out", "F11", "Show the window on all of the screen", checkable=True
    ),
    Command("palette", "Command &palette…", "ph.magnifying-glass", "Ctrl+Shift+P", "Find any command by some letters"),
    Command(
        "shortcuts", "&Keyboard shortcuts…", "ph.keyboard", "F1", "See which keys give which command, and change them"
    ),
    Command("about", "&About ILF Studio", "ph.info"),
    *_OF_CLOUD,
)
_HISTORY_ICONS = {"undo": "ph.arrow-counter-clockwise", "redo": "ph.arrow-clockwise"}


class Actions:
    """The window's QActions by name: `actions["run"]`, and what the undo history gives: "undo" and "redo"."""

    def __init__(self, window: QWidget, history: QUndoGroup) -> None:
        self._window = window
        self._icons = dict(_HISTORY_ICONS)
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        undo, redo = history.createUndoAction(window, "Undo"), history.createRedoAction(window, "Redo")
        undo.triggered.disconnect()  # what undoing means while a stroke is under way is not the history's to say
        undo.setShortcut(QKeySequence("Ctrl+Z"))
        redo.setShortcuts([QKeySequence("Ctrl+Shift+Z"), QKeySequence("Ctrl+Y")])
        for name, action in (("undo", undo), ("redo", redo)):
            action.setObjectName(name)
            action.setProperty(WHY_NOT, f"There is nothing to {name}.")
            self._actions[name] = action
        self._draw_icons(_HISTORY_ICONS)
        self.add(COMMANDS)

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def add(self, commands: Iterable[Command]) -> None:
        """Add the commands of a part of the window, which carries them out itself."""
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
        """Take the icons in the colours of the window's palette."""
        self._draw_icons(self._icons)

    def _draw_icons(self, icons: Mapping[str, str]) -> None:
        palette = self._window.palette()
        for name, icon in icons.items():
            if icon:
                self[name].setIcon(theme.icon(icon, palette))

    def allow(self, why_not: str, *names: str) -> None:
        """Enable several actions, or disable them for a reason: a sentence that says what to do first; "" for none."""
        for name in names:
            self[name].setEnabled(not why_not)
            self[name].setProperty(WHY_NOT, why_not)

"""Frames of a sequence, a folder or a recording are gone through, completed together and played."""

from tests.ilf.bags import write_aligned

from ..frames import walk
from ..hand import Hand


def _open(user: Hand) -> None:
    user.open(walk(user.folder))
    user.set_filter("paper", 15)


def go_through_frames(user: Hand) -> None:
    """Next, previous, done, noted, filtered; the list says what has been done."""
    user.drop(walk(user.folder))
    user.do("next_frame")
    user.do("next_frame")
    user.do("previous_frame")
    user.do("one_to_one")
    user.tool("mark_invalid")
    user.drag([(40, 30), (60, 36)])
    user.do("next_untouched")
    user.do("mark_done")
    frames = user.panel("Frames")
    user.start("note_frame")
    user.write("sun in the picture")
    user.fill("Filter frames by name or note", "sun", frames)
    user.keep("filtered", len(user.rows("Frames", frames)))
    user.fill("Filter frames by name or note", "0", frames)
    user.click_row("Frames", 0, within=frames, twice=True)


def propagate_blocks(user: Hand) -> None:
    """To the next frame, through all others by optical flow, and from the previous one."""
    _open(user)
    user.tool("outline")
    user.fill("Snap", 0)
    user.drag([(20, 10), (60, 10), (60, 40), (20, 40), (20, 11)])
    user.do("propagate_next")
    user.keep_undo("next")
    user.do("propagate_copied")
    user.do("propagate_flow")
    user.do("propagate_auto")
    through = {"Frames": 2, "Method": "Optical flow"}
    user.use_dialog("Propagate blocks of", "propagate_through", through, "Propagate")
    user.do("next_frame")
    user.do("propagate_previous")


def depth_of_neighbours(user: Hand) -> None:
    """Found, tested, used by a run, removed and brought back."""
    _open(user)
    user.do("next_frame")
    user.fill("Frames before and after", 1, user.panel("Additional depth"))
    user.do("use_neighbours")
    user.do("run_all")
    user.keep_project("used")
    user.do("remove_neighbours")
    user.do("undo")


def parameters_for_all_frames(user: Hand) -> None:
    """Shared, kept for one frame, set back to the shared ones, separated."""
    _open(user)
    user.do("share_parameters")
    user.do("next_frame")
    user.do("keep_own_parameters")
    user.fill("Max. iterations", 9)
    user.keep_project("own")
    user.do("reset_to_shared")
    user.fill("Max. iterations", 11)
    user.do("next_frame")
    user.do("run_all")
    user.keep_project("shared")
    user.do("separate_parameters")


def play_the_frames(user: Hand) -> None:
    """From the first to the last, with completion, at several speeds; flicker is seen meanwhile."""
    _open(user)
    user.do("run_all")
    user.choose("View", "View set", "Four with flicker")
    for speed in ("speed_quarter", "speed_half", "speed_normal", "speed_double", "speed_fourfold", "speed_fastest"):
        user.do(speed)
    user.do("play_loop")
    user.do("play_loop")
    user.do("play_completed")
    user.do("play_frames")
    user.keep("shown last", user.title())


def export_all_frames(user: Hand) -> None:
    _open(user)
    user.do("run_all")
    user.use_dialog("Export", "export_all", {"Folder": user.folder / "all"}, "Export", "Close")
    user.keep("all", user.folder / "all")


def batch(user: Hand) -> None:
    """All frames of the list into folders, with a contact sheet."""
    _open(user)
    dialog = user.dialog("Export", "batch")
    user.fill("Folder", user.folder / "done", dialog)
    user.fill("Contact sheet", True, dialog)
    user.press("Export", dialog)
    rows = user.rows("Results of the frames", dialog)
    user.keep("outcomes", [[frame, status] for frame, status, _ in rows])
    depth = sorted((user.folder / "done").rglob("depth.*"))
    for path in depth:
        user.keep(f"batch {path.relative_to(user.folder / 'done')}", path)
    user.press("Close", dialog)


def report(user: Hand) -> None:
    """A page of the frame; its figures are hashed where they are files of their own elsewhere."""
    _open(user)
    user.do("run_all")
    dialog = user.dialog("Export", "report")
    user.fill("Format", "HTML", dialog)
    user.fill("Open when done", False, dialog)
    user.fill("Folder", user.folder / "page", dialog)
    user.press("Export", dialog)
    (page,) = [path.read_text() for path in (user.folder / "page").glob("*.html")]
    user.keep("headings and tables", [page.count(tag) for tag in ("<h1", "<h2", "<table", "<tr", "<img")])
    user.press("Close", dialog)


def frames_of_a_recording(user: Hand) -> None:
    user.drop(write_aligned(user.folder, "ros1"))
    user.do("next_frame")
    user.do("run_all")


def play_a_recording_live(user: Hand) -> None:
    """A recording and a folder, each recorded to its end, where the last frame is opened."""
    for command, source in (("play_recording", write_aligned(user.folder, "ros1")), ("play_folder", walk(user.folder))):
        with user.answering(user.folder / command):
            user.do("play_recorded")
        with user.answering(source):
            user.do(command)

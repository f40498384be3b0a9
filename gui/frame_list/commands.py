"""The commands of the frame list."""

from gui.command import Command

COMMANDS = (
    Command(
        "open_folder",
        "Open &folder of frames…",
        "ph.folders",
        "Ctrl+Shift+F",
        "List the frames of a folder or sequence, and open the first; the others are read when you come to them",
    ),
    Command(
        "open_recording",
        "Open reco&rding…",
        "ph.film-strip",
        "",
        "List the frames of a recording: a bag of ROS, a recording of a camera; a bag of ROS 2 is a folder of frames",
    ),
    Command("next_frame", "&Next frame", "ph.caret-down", "Ctrl+PgDown", "Show the next frame of the list, as shown"),
    Command(
        "previous_frame", "&Previous frame", "ph.caret-up", "Ctrl+PgUp", "Show the frame before in the list, as shown"
    ),
    Command(
        "next_untouched",
        "Next &untouched frame",
        "ph.caret-double-down",
        "Ctrl+Shift+PgDown",
        "Show the next frame that has not been opened yet",
    ),
    Command("note_frame", "N&ote on the frame", "ph.note-pencil", "", "Write down what you want to remember of it"),
)

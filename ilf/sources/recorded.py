"""Reading the images of a frame of a recording."""

from __future__ import annotations

from ..data.frame import FrameInputs, InputFile
from ..errors import InputError
from ..io.depth_reading import interpret_depth
from .frame_ref import FrameRef
from .naming import recorded_frame_name
from .opening import opened
from .poses import stated_pose
from .read_images import ReadImages
from .reading_options import DEPTH_VIEW


def read_recorded(ref: FrameRef, name: str | None = None) -> ReadImages:
    """Read the images of a frame of a recording; options that are not given are those of the recording.

    Raises
    ------
    InputError
        If there is no such recording, or no such frame in it.
    FormatError
        If the recording is damaged.
    ParameterError
        If there is no such encoding.
    """
    key, options, given = ref.frame or "", ref.options, ref.options.depth_encoding
    if options.undistort:
        raise InputError(f"{ref.rgb} is a recording: undistortion applies to files of colour and depth.")
    if options.dataset is not None:
        raise InputError(f"{ref.rgb} is a recording: a dataset is that of a depth file. Leave it out.")
    with opened(ref.rgb) as recording:
        stored, cameras, pose, path = recording.frame(key), recording.cameras(key), recording.pose(key), recording.path
    invalid = stored.invalid if options.invalid is None else options.invalid
    reading = interpret_depth(stored.depth, path, given, stored.encoding, invalid)
    return ReadImages(
        path,
        name or recorded_frame_name(path, key),
        stored.rgb,
        reading.metres,
        reading,
        cameras,
        FrameInputs(
            InputFile(str(path), stored.rgb_sha256),
            InputFile(str(path), stored.depth_sha256),
            reading.encoding.units,
            None,
            encoding=reading.encoding.name,
            invalid=reading.encoding.invalid,
            frame=key,
            view=DEPTH_VIEW if options.view == DEPTH_VIEW else None,
        ),
        notes=(*((cameras.note,) if cameras.note else ()), *reading.notes),
        warnings=reading.warnings,
        pose=pose if options.pose is None else stated_pose(options.pose),
        depth_view=stored.depth_view,
        confidence=stored.confidence,
    )

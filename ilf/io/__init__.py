"""Reading frames and writing results: one module per family of formats.

File units, file names and file formats exist here only; everything else works in metres on arrays.
"""

from ..open3d_images import load_open3d
from .atomic import atomic_path
from .camera_files import intrinsics_from
from .cloud_files import CLOUD_SUFFIXES, check_cloud_format, write_cloud
from .confidence_files import read_confidence
from .depth_files import (
    DEPTH_SUFFIXES,
    UINT16_MAX,
    coarser_units,
    default_depth_units,
    png_fit,
    read_depth_values,
    write_depth,
    write_expected_error,
)
from .encodings import ENCODINGS
from .frame_folders import write_frame
from .frames import META_NAME, FrameFiles, frame_beside, frame_folder, load_frame
from .guide_files import GUIDE_SUFFIXES, load_guide
from .images import read_colour
from .interchange import BLOCK_FORMATS, LoadedBlocks, read_blocks, write_blocks
from .label_files import read_labels, write_labels, write_mask
from .listing import Listing, list_frames
from .mesh_files import MESH_SUFFIXES, write_mesh
from .ros_output import StampedDepth, write_rosbag
from .truth_files import load_truth, with_truth_file

__all__ = [
    "BLOCK_FORMATS",
    "CLOUD_SUFFIXES",
    "DEPTH_SUFFIXES",
    "ENCODINGS",
    "GUIDE_SUFFIXES",
    "MESH_SUFFIXES",
    "META_NAME",
    "UINT16_MAX",
    "FrameFiles",
    "Listing",
    "LoadedBlocks",
    "StampedDepth",
    "atomic_path",
    "check_cloud_format",
    "coarser_units",
    "default_depth_units",
    "frame_beside",
    "frame_folder",
    "intrinsics_from",
    "list_frames",
    "load_frame",
    "load_guide",
    "load_open3d",
    "load_truth",
    "png_fit",
    "read_blocks",
    "read_colour",
    "read_confidence",
    "read_depth_values",
    "read_labels",
    "with_truth_file",
    "write_blocks",
    "write_cloud",
    "write_depth",
    "write_expected_error",
    "write_frame",
    "write_labels",
    "write_mask",
    "write_mesh",
    "write_rosbag",
]

"""Sources of frames (folders, data sets, recordings, cameras) behind one interface."""

from .named_places import allow_address as allow_address

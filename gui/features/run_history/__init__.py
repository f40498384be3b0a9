"""The run history of a frame: its table and panel."""

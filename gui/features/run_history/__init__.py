"""The run history of a frame: errors, table, file and panel."""

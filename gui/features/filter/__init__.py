"""Parameters of the filter: panel, presets, shared by all frames or for a single one."""

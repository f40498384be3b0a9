"""The filter's parameters: panel, presets, for all frames or this one."""

"""Common to all packages of the window: theme, commands, paths, versions."""

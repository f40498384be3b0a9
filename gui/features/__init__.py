"""Features of the window: a package or a module each, with its panel, dialog, presenter and commands."""

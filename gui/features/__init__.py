"""Features of the window: a package or a module each, with its panel, dialogs and commands."""

"""The window: see `app` for its assembly, `features` for what a user does in it."""

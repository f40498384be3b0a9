"""What every room of the window uses: theme, commands, the context that features share."""

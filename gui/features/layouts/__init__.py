"""The layouts of the window: turning to them, keeping them, and going back."""

"""What a user does: a room or a file each, with its panel, dialog, presenter and commands together."""

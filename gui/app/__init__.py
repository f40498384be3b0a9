"""The main window and its assembly: menus, docks, start and end."""

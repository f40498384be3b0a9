"""Many frames of the list, completed in the background into a folder each."""

"""Quality checks of blocks and depth, one place after the other, and suggestions of invalid depth."""

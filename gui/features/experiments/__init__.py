"""The paper's experiments in the window: a menu, and a window that runs and shows them."""

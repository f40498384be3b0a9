"""Pure edits of a label map. Each gives a patch that can be applied and reverted, or None if nothing would change."""

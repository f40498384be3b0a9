"""Quality checks: places where blocks and depth look wrong, and known depth that is likely invalid."""

"""NC programs, points and tables rewritten so that known errors of the machine cancel, with their proof."""

"""Marin et al. 2004: a mill that warms up, its error model and a rewritten program."""

"""Marin et al. 2004: chain of a milling machine, warm-up, rewritten program."""

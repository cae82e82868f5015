"""Marin et al. 2004: a mill that warms up, its error model and a rewritten program.

Imports core, effects, report, charts, nc, machining, files, library, compensating, calibrating, tables, papers.
"""

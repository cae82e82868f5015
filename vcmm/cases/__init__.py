"""Worked cases that are no papers: a test piece, a worn measuring machine.

Imports core, part, gps, effects, report, charts, measuring, response, instruments, evaluation, machining, files,
diagnosis, tables, pages, papers.
"""

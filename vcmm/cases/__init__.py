"""Worked cases that are no papers: a test piece, a worn measuring machine.

Imports core, part, gps, effects, report, measuring, response, evaluation, machining, diagnosis, tables, pages,
papers.
"""

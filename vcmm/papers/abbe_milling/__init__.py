"""Abbe-consistent volumetric errors: slots milled under two models of the same machine.

Imports core, effects, report, charts, measuring, response, instruments, machining, files, library, tables, papers.
"""

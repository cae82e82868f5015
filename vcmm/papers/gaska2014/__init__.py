"""Gaska et al. 2014: a virtual CMM from nodes with residual errors, five places of one part.

Imports core, gps, effects, report, charts, measuring, response, instruments, evaluation, placing, files, library,
calibrating, tables, console, pages.
"""

"""Gaska et al. 2014: a virtual CMM from nodes with residual errors, five places of one part.

Imports core, gps, effects, report, measuring, response, evaluation, placing, files, library, tables, console, pages.
"""

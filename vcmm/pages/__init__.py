"""The page of every job, put together from the blocks of report.

Imports core, part, gps, effects, report, nc, cutting, measuring, response, evaluation, placing, machining, diagnosis,
calibrating, tables.
"""

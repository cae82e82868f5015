"""The page of every job, put together from the blocks of report.

Imports core, part, gps, effects, report, charts, nc, cutting, measuring, response, evaluation, inference, routes,
placing, machining, compensating, diagnosis, calibrating, tables.
"""

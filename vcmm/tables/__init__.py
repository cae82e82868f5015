"""Every table of results: columns declared once for terminal, page, CSV and documents.

Imports core, gps, report, nc, motion, measuring, response, evaluation, inference, routes, placing, machining,
compensating, diagnosis, calibrating.
"""

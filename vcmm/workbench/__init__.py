"""The page of a task, live on this machine: knobs in a browser, and U, decision and budget moving with them.

Imports core, gps, report, measuring, evaluation, files, diagnosis, api, tables, console, pages.
"""

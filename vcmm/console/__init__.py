"""What every command shares: documents, tables, whole files, progress.

Imports core, nc, evaluation, files, tables.
"""

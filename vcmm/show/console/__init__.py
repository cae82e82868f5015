"""Shared parts of all commands: documents, tables, whole files, progress."""

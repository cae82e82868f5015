"""Worked cases that are no papers: a test piece, a worn measuring machine."""

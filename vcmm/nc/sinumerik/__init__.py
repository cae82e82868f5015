"""Sinumerik programs.

Imports core, nc.
"""

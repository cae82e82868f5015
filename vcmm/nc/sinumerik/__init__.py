"""Sinumerik programs. Imports nc."""

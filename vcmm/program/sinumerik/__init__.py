"""Sinumerik programs."""

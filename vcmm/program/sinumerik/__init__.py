"""Readers of Sinumerik programs."""

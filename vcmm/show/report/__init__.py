"""Blocks of a page: tables, charts, scenes. They know numbers, not measuring."""

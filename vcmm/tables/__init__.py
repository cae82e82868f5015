"""Every table of results: its columns, declared once, serve the terminal, the page, CSV and JSON. Imports every job."""

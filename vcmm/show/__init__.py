"""Result tables and their readings: terminal, page, chart, workbench."""

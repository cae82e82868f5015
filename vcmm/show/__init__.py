"""Result tables and their presentations: terminal, page, chart, workbench."""

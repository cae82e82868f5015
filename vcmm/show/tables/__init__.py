"""All tables of results: columns declared once for terminal, page, CSV and documents."""

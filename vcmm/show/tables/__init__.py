"""Every table of results: columns declared once for terminal, page, CSV and documents."""

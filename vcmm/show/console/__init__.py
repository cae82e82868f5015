"""What every command shares: documents, tables, whole files, progress."""

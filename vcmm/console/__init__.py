"""What every command shares: JSON documents, tables, files written whole, progress. Imports core and files."""

"""What every command shares: JSON documents, files written whole, tables and progress, complaints. Imports files and tables."""

"""What else may be wrong: any file can be deleted with its lines in the list of physics, and nobody imports one."""

"""Further effects: no module imports a file of this folder, and any of them can be deleted with its lines in the list of physics."""

"""A test piece as in ISO 10791-7: which error of a mill shows in which of its features."""

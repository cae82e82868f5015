"""Virtual machining: the part that a machine tool will cut, with its uncertainty."""

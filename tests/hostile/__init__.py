"""Files that nobody in his right mind writes, and machines that fail in the middle: every reader, every writer."""

"""The best pose of a part and the best points of a plan, and by how much any other could be better."""

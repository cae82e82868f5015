"""Find the best pose of a part and the best points of a plan, and estimate how much better any other could be."""

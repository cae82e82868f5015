"""Placement: the pose that serves best, and by how much any other could still be better."""

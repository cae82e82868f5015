"""The drawing: features in the drawing frame, mesh, form, alignment."""

"""Second routes to the same result: a calibrated part, repeats in several positions, and their agreement with the model."""

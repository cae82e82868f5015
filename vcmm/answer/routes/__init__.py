"""Second routes to the same result: a calibrated part, repeats in several positions, and how well they agree with the model."""

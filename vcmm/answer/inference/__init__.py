"""What measured data say of the true values: points and values taken in, the audit."""

"""What several twins share: drawn error tables, departures of a virtually cut surface."""

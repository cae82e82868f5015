"""Fagor 8055 and 8025 programs of mills."""

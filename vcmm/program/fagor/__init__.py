"""Fagor programs of mills."""

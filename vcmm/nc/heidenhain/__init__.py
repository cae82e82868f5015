"""HEIDENHAIN Klartext programs. Imports nc."""

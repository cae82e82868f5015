"""The part: features, drawing frame, mesh, form, and how it is aligned. Imports core and fit."""

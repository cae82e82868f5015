"""The measuring task: plan, points, contact, qualification, fixture, scenario. Imports core, part, fit and gps."""

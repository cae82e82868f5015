"""The measuring task: plan, strategies, contact, qualification, fixture, scenario."""

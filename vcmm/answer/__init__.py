"""Knowledge pushed through a task: uncertainty, true values from measured ones, placement, second routes."""

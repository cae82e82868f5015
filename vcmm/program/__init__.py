"""What NC programs mean, in all languages: moves, tools, set-up, state of the control, cutter compensation."""

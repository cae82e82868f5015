"""Subjects of the Python interface: each module is offered by `import vcmm` under its own name, as `vcmm.machining`."""

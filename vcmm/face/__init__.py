"""User interfaces: the command line and the functions of `import vcmm`."""

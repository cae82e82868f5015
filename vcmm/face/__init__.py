"""What people call: the command line and the functions of `import vcmm`."""

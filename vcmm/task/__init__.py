"""The measuring task: plan and contact, the columns of G, instruments, machines known by a certificate alone."""

"""What solves a problem on this machine: samplers, integer programs, windows of a problem."""

"""Questions asked of the simulators: the paper again, and rigid against softened."""

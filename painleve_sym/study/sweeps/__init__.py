"""Sweeps: one motion for every point of a grid or a sampled set."""

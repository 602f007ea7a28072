"""Proofs that a function is positive on a box: balls prove it, another arithmetic verifies it."""

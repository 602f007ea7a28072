"""Proofs that a function is positive on a box: balls prove it, and intervals verify the proof."""

"""Impulse rays and classes of planar impact in closed form."""

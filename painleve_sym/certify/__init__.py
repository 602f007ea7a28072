"""Proofs that a function is positive on a box: balls prove it, another arithmetic verifies it."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

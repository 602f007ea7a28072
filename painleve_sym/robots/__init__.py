"""Robots: files, rigid-body dynamics, and the friction from which a contact is at risk."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

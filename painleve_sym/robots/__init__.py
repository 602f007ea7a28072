"""Robots: files, rigid-body dynamics, and the friction from which a contact is at risk."""

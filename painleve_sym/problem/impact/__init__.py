"""Impacts of rigid contacts by their numbers: W, friction, velocities and restitution."""

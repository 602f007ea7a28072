"""Velocity jumps at finite contact stiffness."""

"""Runge–Kutta 8(5,3): coefficients and stepper."""

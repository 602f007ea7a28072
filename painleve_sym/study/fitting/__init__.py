"""Estimation of parameters from measurements."""

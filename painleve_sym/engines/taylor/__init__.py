"""The Taylor-series engine: recurrences from the expression graph, events on the series."""

ORDER = 20
"""Highest order; that for the tightest tolerance, 1e-15, is 19."""

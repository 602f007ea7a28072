"""The Taylor-series engine: recurrences from the expression graph, events on the series."""

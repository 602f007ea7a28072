"""Studies: scenarios, maps, sweeps, fits and comparisons."""

"""Studies: scenarios, maps, sweeps, fits and comparisons."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

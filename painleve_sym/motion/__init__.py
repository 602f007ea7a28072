"""Motion: numbers in, one `Trajectory` out."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

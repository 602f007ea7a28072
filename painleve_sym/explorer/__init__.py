"""The explorer: one HTML page in which a mechanism's contact mechanics is computed live."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

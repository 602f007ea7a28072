"""Reproduction of published work: one folder per paper, with its claims as data.

A paper is a folder here that holds ``claims.toml``, the claims with their expected verdicts
(`claims.read_claims`), and a module ``items`` with two names: ``COMPUTE`` maps each item of the
claims to a function that returns its `item.ItemOutcome`; ``Workbench``, called without arguments,
makes the one argument that these functions share. Adding the folder is all that a paper needs.
"""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)

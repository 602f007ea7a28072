"""SymPy only: a mechanism and its contacts become closed forms."""

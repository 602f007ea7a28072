"""One script per derivation; `python -m derivations` runs them all."""

"""Mechanism files in TOML."""

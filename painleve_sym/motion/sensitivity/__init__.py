"""Motions with their first derivatives."""

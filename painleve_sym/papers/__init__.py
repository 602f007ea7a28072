"""Reproduction of published work: claims as data, items and verdicts."""

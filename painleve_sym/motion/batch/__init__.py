"""Batches: many motions of one simulator."""

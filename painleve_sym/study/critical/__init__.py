"""The critical force that separates lift-off from impact, and studies of it."""

"""Batches: motions of one simulator from arrays of inputs."""

"""Motion: numbers in, one `Trajectory` out."""

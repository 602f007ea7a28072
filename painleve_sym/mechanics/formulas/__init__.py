"""Every closed form of a mechanism as a named formula: text, LaTeX, Python."""

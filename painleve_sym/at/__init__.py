"""Contact problems and impacts at states of a mechanism: W and b, closed states, cases, jumps."""

"""From automata to compiled code: the only place that knows both SymPy and CasADi."""

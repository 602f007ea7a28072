"""Contact laws as symbolic expressions with parameters; nothing is integrated here."""

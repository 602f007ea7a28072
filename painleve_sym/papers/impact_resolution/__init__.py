"""The paper: Impact model resolution on Painlevé's paradox."""

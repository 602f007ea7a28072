"""Conditions of the paradox in closed form."""

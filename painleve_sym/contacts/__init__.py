"""Contacts: what one contact may do, and several together."""

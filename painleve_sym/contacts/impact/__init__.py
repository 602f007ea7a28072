"""Impacts of rigid contacts."""

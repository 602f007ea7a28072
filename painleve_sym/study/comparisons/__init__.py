"""Methods compared from one state: rigid, compliant, time stepping, jump rules."""

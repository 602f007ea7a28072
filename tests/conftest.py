"""Hypothesis profiles: the same examples in every run, or new ones to find faults."""

import os

from hypothesis import settings

# Deterministic examples: a failure is caused by the change, not by sampling.
settings.register_profile("repeatable", derandomize=True, print_blob=True)
settings.register_profile("explore", print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

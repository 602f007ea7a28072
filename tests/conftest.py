"""Hypothesis profiles: the same examples in every run, or new ones to find faults."""

import os

from hypothesis import settings

# A red run then tells of the change at hand, not of the draw.
settings.register_profile("repeatable", derandomize=True, print_blob=True)
settings.register_profile("explore", print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

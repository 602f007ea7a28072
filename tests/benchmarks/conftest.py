"""Benchmarks measure the code that users get."""

import os

os.environ["PAINLEVE_OPTIMIZE"] = ""

"""The motion as C code that stands alone."""

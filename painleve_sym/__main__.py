"""Run the command line: ``python -m painleve_sym``."""

from painleve_sym.cli import main

if __name__ == "__main__":
    raise SystemExit(main())

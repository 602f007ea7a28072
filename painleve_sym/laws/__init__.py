"""Contact laws as symbolic expressions with parameters; nothing is integrated here.

The functions of this module return each law with its choices, and with other defaults of its
parameters where these are given.
"""

from painleve_sym.doors import door
from painleve_sym.laws.compliant_laws import *  # noqa: F403 - each law that its file offers
from painleve_sym.laws.compliant_laws import __all__ as _compliant

_others, __getattr__, _ = door(__name__)
__all__ = sorted([*_compliant, *_others])


def __dir__() -> list[str]:
    return __all__

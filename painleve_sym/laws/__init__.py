"""Contact laws as symbolic expressions with parameters; nothing is integrated here.

The functions of this module return each law with its choices, and with other defaults of its
parameters where these are given.
"""

from painleve_sym.doors import door
from painleve_sym.laws.compliant_laws import *  # noqa: F403 - each law that its file offers
from painleve_sym.laws.compliant_laws import __all__ as _compliant
from painleve_sym.laws.rigid_contact import rigid as rigid

_others, __getattr__, _ = door(__name__)
__all__ = [*_compliant, "rigid"]


def __dir__() -> list[str]:
    return sorted({*__all__, *_others})

from painleve_sym.papers.registry import Reproduction as Reproduction
from painleve_sym.papers.registry import reproduce as reproduce

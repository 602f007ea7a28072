from painleve_sym.codegen.mode_equations import ModeEquations as ModeEquations
from painleve_sym.codegen.modes import AutomatonFunctions as AutomatonFunctions
from painleve_sym.codegen.named_mechanisms import model as model

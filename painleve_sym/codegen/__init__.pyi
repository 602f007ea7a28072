from painleve_sym.codegen.modes import AutomatonFunctions as AutomatonFunctions
from painleve_sym.codegen.named_mechanisms import model as model

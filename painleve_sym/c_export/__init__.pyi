from painleve_sym.c_export.export import Export as Export
from painleve_sym.c_export.export import export_c as export_c
from painleve_sym.c_export.fmu import Fmu as Fmu
from painleve_sym.c_export.fmu import export_fmu as export_fmu

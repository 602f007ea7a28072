from painleve_sym.c_export.export import Export as Export
from painleve_sym.c_export.export import export_c as export_c

from painleve_sym.laws.catalogue import LawsByContact as LawsByContact
from painleve_sym.laws.catalogue import law as law
from painleve_sym.laws.compliance import Branch as Branch
from painleve_sym.laws.compliance import Exit as Exit
from painleve_sym.laws.compliant_laws import *
from painleve_sym.laws.contact_law import ContactLaw as ContactLaw
from painleve_sym.laws.formulas import closed_forms as closed_forms
from painleve_sym.laws.rigid_contact import RigidLaw as RigidLaw
from painleve_sym.laws.rigid_contact import rigid as rigid

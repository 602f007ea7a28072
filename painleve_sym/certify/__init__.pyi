from painleve_sym.certify.checker import Rejected as Rejected
from painleve_sym.certify.checker import check as check
from painleve_sym.certify.proof import Decision as Decision
from painleve_sym.certify.proof import Proof as Proof
from painleve_sym.certify.proof import prove_positive as prove_positive

"""Named choices of laws by contact."""

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import LawsByContact, law
from painleve_sym.motion.simulator import Simulator


def test_choices_that_differ_are_kept_by_contact():
    last, virgin = law("bilinear-hertz"), law("bilinear-hertz", reload="virgin")
    both = {"reload_A": last.choices["reload"], "reload_B": "virgin"}
    assert last.choices["reload"] != "virgin"
    laws = LawsByContact({"A": last, "B": virgin})
    assert laws.choices == both
    assert Simulator(model("block-two-feet"), laws).choices == both


def test_choices_that_agree_keep_their_name():
    virgin = law("bilinear-hertz", reload="virgin")
    laws = LawsByContact({"A": virgin, "B": law("rigid"), "C": virgin})
    rigid = {"restitution": "energetic", "impact_friction": "path", "policy": "liftoff"}
    assert laws.choices == {"reload": "virgin"} | rigid

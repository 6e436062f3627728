"""From an estimate to a decision."""

from ..estimate.evidence import Kind
from ._cone_kernel import SlipVerdict
from .friction import Friction
from .grip import least_force
from .slip import Slip, slip
from .stick import friction_arm, slipping_about, stick_zone
from .type_decision import UNDECIDED, TypeDecision, contact_type, usual_kinds

__all__ = [
    "UNDECIDED", "Friction", "Kind", "Slip", "SlipVerdict", "TypeDecision", "contact_type", "friction_arm",
    "least_force", "slip", "slipping_about", "stick_zone", "usual_kinds",
]  # fmt: skip

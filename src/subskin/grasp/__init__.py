"""A hand that holds by its skins: a controller, things to lift in simulation, and what comes of it."""

from .hand import Hand, HandCommand, Phase
from .lifting import Lifted, lift, pad_finger
from .peers import ConeHand, FixedHand, ForceHand
from .scene import Thing, gripper_xml, things
from .trials import HANDS, hand_of, lifts, summary

__all__ = [
    "HANDS",
    "ConeHand",
    "FixedHand",
    "ForceHand",
    "Hand",
    "HandCommand",
    "Lifted",
    "Phase",
    "Thing",
    "gripper_xml",
    "hand_of",
    "lift",
    "lifts",
    "pad_finger",
    "summary",
    "things",
]

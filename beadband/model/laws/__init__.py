"""Material laws: one class each, usable everywhere the moment it is registered.

Your own law is a class like :class:`~beadband.model.laws.mooney_rivlin.MooneyRivlin` under ``@register``, in any
file: name the file in the environment variable BEADBAND_PLUGINS, or a module of it in the entry points of the group
``beadband.laws``.
"""

from beadband.model.laws.base import Law, constant
from beadband.model.laws.gent import Gent
from beadband.model.laws.linear import Linear
from beadband.model.laws.mooney_rivlin import MooneyRivlin
from beadband.model.laws.neo_hookean import NeoHookean
from beadband.model.laws.ogden import Ogden
from beadband.model.laws.registry import LAWS, law_of, register
from beadband.model.laws.softening import Softened
from beadband.model.laws.tensile import Tensile, Unloading
from beadband.model.laws.unloading import UnloadingWave, WavePart
from beadband.model.laws.yeoh import Yeoh
from beadband.plugins import load_plugins

__all__ = [
    "LAWS",
    "Gent",
    "Law",
    "Linear",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Softened",
    "Tensile",
    "Unloading",
    "UnloadingWave",
    "WavePart",
    "Yeoh",
    "constant",
    "law_of",
    "register",
]

load_plugins()

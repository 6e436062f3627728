"""Files: `finger.toml`, tables of readings, raw recordings. Units are turned into SI here and nowhere else."""

from .. import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)

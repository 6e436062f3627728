"""The last step of an estimate where the finger, and the size of a touch, are not known exactly.

`normal.py` has the equations, `variants.py` the readings that fingers make which are not quite their drawing,
`frames.py` the loop over frames, `elsewhere.py` the search for another load, and `uncertain.py` what Python prepares.
"""

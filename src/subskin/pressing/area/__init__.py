"""Presses on an area: the solver, its grids, and what it gives back."""

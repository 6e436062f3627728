"""The memo's figures alive: each a function of a few numbers, with its equations as printed and as corrected."""

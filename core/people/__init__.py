"""A dressed person's raw scan taken apart: the wearer, and the parts of what is seen."""

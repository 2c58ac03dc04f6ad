"""The cloth simulator: from a sewn garment, a fabric and a body to an equilibrium drape."""

"""PhyDeformer: a garment mesh deformed onto a target by per-triangle Jacobians (thesis chapter 4)."""

"""Base patterns from parts: a garment's cut as one choice for each part, and the drafts of the parts."""

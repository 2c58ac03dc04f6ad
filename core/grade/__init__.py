"""Linear grading of a base pattern from contour distances along the bones (thesis 3.2.3)."""

"""Grade a base pattern by its contours along the bones and the stretch between them (thesis 3.2.3)."""

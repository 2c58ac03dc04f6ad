"""Contact of cloth with cloth: near pairs, the barrier between them, and steps without intersections."""

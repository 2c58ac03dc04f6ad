"""Uses of a recovered garment: on other bodies, animated, edited."""

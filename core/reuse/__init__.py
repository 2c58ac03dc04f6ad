"""What a recovered garment is used for: worn by other bodies, animated, edited."""

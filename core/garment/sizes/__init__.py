"""Grade a pattern to sizes: growth of the wearer, rules, named points, and the figures of a grade table."""

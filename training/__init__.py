"""Developer's tools that teach the parts of a dressed person: simulated persons, and trainers. Nothing imports them."""

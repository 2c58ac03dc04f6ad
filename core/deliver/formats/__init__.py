"""Writers of production formats, for cutting, printing and cutting programs."""

"""Bodies of other models, by their own files: their skeletons are reduced to ours, and their vertices are kept."""

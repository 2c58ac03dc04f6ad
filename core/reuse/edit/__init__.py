"""A result's pattern edited: draped from where its garment hangs, judged, and compared with what it was."""

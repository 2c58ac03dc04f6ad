"""Output: files for print, cutting, other programs and browsers."""

"""What leaves the program: files for print, cutting, other programs and browsers."""

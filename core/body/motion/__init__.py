"""Motions of a wearer: read from files, retargeted to the wearer's skeleton, sampled at any time."""

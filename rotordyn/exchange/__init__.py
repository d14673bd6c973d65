"""Superelements in the files of other programs, and back; one module for each format."""

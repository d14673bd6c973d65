"""Motions of asymmetric rotors in time: run-ups, growth by fit, and where it ends."""

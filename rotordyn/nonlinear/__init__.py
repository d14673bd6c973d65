"""Steady response of a system with a few nonlinear forces, by harmonic balance."""
